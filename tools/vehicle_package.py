"""Makes the archive of the vehicle's library, whose root is the library: build/LARICS-VERSION.zip.

    python tools/vehicle_package.py [FOLDER] [--url URL]

URL: where the library is published; without it the archive keeps a placeholder (.example is reserved, it
leads nowhere). The Arduino IDE takes the archive as it is ("Add .ZIP Library"); PlatformIO, CMake, ESP-IDF
and Zephyr find their files in it. The same sources give the same bytes.
"""

import argparse
import pathlib
import re
import sys
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "firmware" / "vehicle"
PLACEHOLDER = "https://larics-camera.example/vehicle"


def version():
    return re.search(r"^version=(.+)$", (LIBRARY / "library.properties").read_text(), re.MULTILINE).group(1)


def public_headers():
    """Those that a user includes; the others say in their first sentence that they are private."""
    headers = sorted((LIBRARY / "src").glob("*.h"))
    return [path for path in headers if "private to the library" not in path.read_text().split("*/")[0]]


def keywords():
    """Text of keywords.txt: what the headers declare, for the colours of the Arduino IDE."""
    text = "".join(path.read_text() for path in public_headers())
    types = sorted(set(re.findall(r"^} (larics_\w+);", text, re.MULTILINE)))
    functions = sorted(set(re.findall(r"^[a-z]\w*[ \w*]* \*?(larics_\w+)\(", text, re.MULTILINE)))
    constants = sorted(set(re.findall(r"^#define (LARICS_\w+) ", text, re.MULTILINE)))
    lines = [*("%s\tKEYWORD1" % name for name in types), *("%s\tKEYWORD2" % name for name in functions)]
    return "\n".join([*lines, *("%s\tLITERAL1" % name for name in constants)]) + "\n"


def files(url=PLACEHOLDER):
    """[(name in the archive, bytes)]"""
    found = [("LICENSE", (ROOT / "LICENSE").read_bytes()), ("keywords.txt", keywords().encode())]
    for path in sorted(LIBRARY.rglob("*")):
        if path.is_file() and path.suffix not in (".o", ".pyc"):
            data = path.read_bytes().replace(PLACEHOLDER.encode(), url.encode())
            found.append((str(path.relative_to(LIBRARY)), data))
    return sorted(found)


def make(folder, url=PLACEHOLDER):
    """Writes the archive; returns its path. ValueError when the URL is none."""
    if not re.fullmatch(r"https?://[!-~]+", url) or set(url) & set("\\\"'<>"):
        raise ValueError("%r is no URL: give https://..." % url)
    name = "LARICS-" + version()
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / (name + ".zip")
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files(url):
            entry = zipfile.ZipInfo("%s/%s" % (name, path), (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data)
    return target


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default=ROOT / "build", type=pathlib.Path)
    parser.add_argument("--url", default=PLACEHOLDER, help="where the library is published")
    options = parser.parse_args(arguments)
    try:
        print(make(options.folder, options.url))
    except (ValueError, OSError) as error:
        print("vehicle-package: %s" % error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
