"""What each kernel must give, computed another way: numpy in floating point, or the plain definition.

ORACLES: module.kernel -> function(arguments before the call, arguments after it, result) that asserts. The
arguments are those of the cases_<module>.py. Each module of this package has those of one kind.
"""

from . import blur, candidates, coarse, edges, lines, rings, samples, shares, statistics, stream, votes

ORACLES = {
    "%s.%s" % (module, oracle.__name__): oracle
    for kind in (blur, candidates, coarse, edges, lines, rings, samples, shares, statistics, stream, votes)
    for module, several in kind.ORACLES.items()
    for oracle in several
}
