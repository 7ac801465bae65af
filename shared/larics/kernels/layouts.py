"""The items of every array that kernels and their callers share: one definition each.

Compilers fold constants only within a module. So whoever uses an item repeats it there as `_NAME = const(n)`,
and tools/check_rules.py compares these copies with this module, which no board ever loads. A name begins with
its array's: FIT, SHAPE, ...

Lengths are in px unless said otherwise; _Q8 and _Q10 are 1/256 and 1/1024 px. Items that may be negative are
stored with BIAS added, because a negative load through ptr32 is signed on 32-bit boards alone.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

BIAS = const(1 << 24)

# GRID, the points of a frame where edges are looked for (detect.edges): left <= x < right, top <= y < bottom
GRID_WIDTH = const(0)  # of the frame
GRID_REACH = const(1)  # distance of the pixels whose difference is the gradient, 1..3
GRID_LEFT = const(2)
GRID_RIGHT = const(3)
GRID_TOP = const(4)
GRID_BOTTOM = const(5)
GRID_STEP = const(6)  # between columns, and between rows
GRID_FIRST = const(7)  # positions for which all pixels that tell a thin line lie in the frame: from this one
GRID_END = const(8)  # to before this one
GRID_ITEMS = const(9)

# CELLS, the grid of cells in which edges vote for centres (detect.centre_votes)
CELLS_WIDTH = const(0)  # of the frame
CELLS_STEP = const(1)  # between cells
CELLS_ROW = const(2)  # cells in a row
CELLS_PADDING = const(3)  # cells around those of the frame
CELLS_OUTER = const(4)  # entries of a run of votes for the outer ring, even,
CELLS_INNER = const(5)  # for the inner one
CELLS_ITEMS = const(6)

# RADII, the outer radii of one scale, and how far from a candidate edges may lie (direct.ring_fit)
RADII_WIDTH = const(0)  # of the frame
RADII_FIRST = const(1)  # to try, half px
RADII_LAST = const(2)
RADII_BINS = const(3)  # of the histogram: the last radius and three, at least
RADII_REACH_Q4 = const(4)  # farthest edge, 1/16 px, 0..4096
RADII_HALF_LINE_Q4 = const(5)  # half the line's width, 0..256
RADII_SLACK_Q4 = const(6)  # by how much an edge may point past the candidate
RADII_INNER_Q10 = const(7)  # ratio of the rings
RADII_CAPACITY = const(8)  # edges that may point to one candidate
RADII_ITEMS = const(9)

# FIT, the pose of a candidate of the direct reader and what a pass over its rings takes from it
FIT_X_Q8 = const(0)  # centre used for the last pass
FIT_Y_Q8 = const(1)
FIT_WINDOW_Q8 = const(2)  # to both sides of a ring
FIT_CLIP = const(3)  # log units
FIT_LEAST_AREA = const(4)  # that a crossing must have to count
FIT_LIMIT_Q10 = const(5)  # largest residual that counts
FIT_RADIUS_Q8 = const(6)  # of the outer ring, centre of its line;
FIT_INNER_Q8 = const(7)  # of the inner one: the next item
FIT_BULGE_COS = const(8)  # second harmonic of the outer radius, 1/1024 px, + BIAS
FIT_BULGE_SIN = const(9)
FIT_X_Q10 = const(10)  # centre, mean of the rings', + BIAS
FIT_Y_Q10 = const(11)
FIT_TRUE_X_Q10 = const(12)  # centre with the correction for perspective, + BIAS
FIT_TRUE_Y_Q10 = const(13)
FIT_AREA = const(14)  # darkness times width of the rings' line, log units * px; 0 before the first pass
FIT_MOVED_Q10 = const(15)  # by the last pass
FIT_INNER_Q10 = const(16)  # the marker's geometry for an outer radius of 1024: radius of the inner ring,
FIT_LINE_Q10 = const(17)  # width of the lines,
FIT_GAP_Q10 = const(18)  # half the gap between the rings
FIT_BEYOND_Q8 = const(19)  # of the rings' centres' difference, how far the true centre is beyond their mean
FIT_WIDTH = const(20)  # of the frame
FIT_HEIGHT = const(21)
FIT_ITEMS = const(22)

# SHAPE, where a marker's lines are looked for; lengths for an outer radius of 1024, below 2048
SHAPE_LINE_FIRST = const(0)  # orientation line: radii where its measuring begins and ends,
SHAPE_LINE_LAST = const(1)
SHAPE_WINDOW = const(2)  # half the window across it,
SHAPE_LINE = const(3)  # width of all lines
SHAPE_IN_LINE = const(4)  # radius of samples in the line,
SHAPE_BEYOND = const(5)  # of those beyond its end,
SHAPE_BESIDE = const(6)  # distance of samples beside it, below 512
SHAPE_AROUND_FIRST = const(7)  # annulus in which a dark direction is looked for: radii,
SHAPE_AROUND_LAST = const(8)
SHAPE_AROUND_SAMPLES = const(9)  # samples in a direction, 2..16,
SHAPE_AROUND_STRIDE = const(10)  # every so-manyth of 256 directions
SHAPE_CODE_FIRST = const(11)  # coding lines: radii,
SHAPE_CODE_LAST = const(12)
SHAPE_CODE_RADII = const(13)  # number of radii, even, 2..16,
SHAPE_CODE_OPENING = const(14)  # farthest sample across, 256ths of the radius
SHAPE_ITEMS = const(15)

# RING, the harmonics of one ring (harmonics.ring_harmonics); coefficients 1/1024 px, + BIAS
RING_CONSTANT = const(0)
RING_COS = const(1)
RING_SIN = const(2)
RING_COS_2 = const(3)
RING_SIN_2 = const(4)
RING_DEVIATION = const(5)  # mean, 1/1024 px
RING_USED = const(6)  # sectors used, of 16,
RING_INSIDE = const(7)  # with crossings
RING_MEAN_AREA = const(8)  # of the used ones
RING_ITEMS = const(9)

# CROSSING, how pixel rows or columns cross the orientation line (lines.line_crossings)
CROSSING_INSIDE = const(0)  # crossings inside the frame,
CROSSING_OUTSIDE = const(1)  # outside
CROSSING_AREA_SUM = const(2)
CROSSING_COUNTED = const(3)  # with at least 3/8 of the rings' area
CROSSING_ROTATION = const(4)  # 1/65536 turn, to be added to the clockwise angle; may be negative
CROSSING_SLOPE = const(5)  # steepness of the centroids against the radius, 1/1024
CROSSING_DISTANCE = const(6)  # mean distance of the centroids from the line, 1/1024 px
CROSSING_AREA = const(7)  # mean area, 256 = as the rings'
CROSSING_GAP = const(8)  # share of those with less than 3/8, 256 = all
CROSSING_SLOPE_MOST = const(9)  # largest steepness to be expected
CROSSING_ANGLE = const(10)  # corrected
CROSSING_ITEMS = const(11)

# POSITION, what lies at each of the eight positions inside the rings (code.code_positions); areas: 256 = as
# the rings'
POSITION_NEAR = const(0)  # of the inner half, below the darker of both sides,
POSITION_FAR = const(1)  # of the outer half
POSITION_NEAR_MEAN = const(2)  # both again, below the mean of the sides, + BIAS
POSITION_FAR_MEAN = const(3)
POSITION_LEVEL = const(4)  # of grey beside it, log units
POSITION_ROUGH = const(5)  # mean square of what lies off the line between both sides, 7168 = as deep,
# at most 65535
POSITION_ITEMS = const(6)

# PLACE, where a marker lies whose cells are read, of either reader (cells.cell_depths)
PLACE_X_Q8 = const(0)  # projected centre
PLACE_Y_Q8 = const(1)
PLACE_RADIUS_Q8 = const(2)  # of the outer ring
PLACE_E1_Q14 = const(3)  # ellipse as in polar.polar_samples, + BIAS
PLACE_E2_Q14 = const(4)
PLACE_HX_Q14 = const(5)  # perspective, likewise
PLACE_HY_Q14 = const(6)
PLACE_COSINE_Q14 = const(7)  # direction of the orientation line in the plane of the marker, + BIAS
PLACE_SINE_Q14 = const(8)
PLACE_DEPTH = const(9)  # of a dark cell against the white beside it, log units, at least 1
# for an outer radius of 1024 where they are looked at: two radii beside the cells,
PLACE_RADII_Q10 = const(10)
PLACE_BESIDE_2_Q10 = const(11)
PLACE_CELL_Q10 = const(12)  # and two in them
PLACE_CELL_2_Q10 = const(13)
PLACE_WIDTH = const(14)  # of the frame
PLACE_HEIGHT = const(15)
PLACE_ITEMS = const(16)

# WORD, what the cells tell (cell_search.likeliest_words); a cell that leaves no doubt costs 64
WORD_ID = const(0)  # of the word that costs least, 0 for the empty one,
WORD_COST = const(1)  # what it costs,
WORD_SECOND = const(2)  # and what the second costs, at least
WORD_ITEMS = const(3)

# The blur-model reader's units of length, bars and directions of motion: see kernels.blur
RELS = const(17)  # angles from the motion, 1/32 of half a turn: 0..16
BAR = const(24)  # items of a bar
ALONG = const(408)  # first item of the bar with a line's profile along itself, after those of all rels
STILL = const(32)  # direction of motion, 1/32 of half a turn, of what does not move

# CIRCLE, the pose of the rings of a candidate of the blur-model reader (polar.polar_samples)
CIRCLE_X_Q8 = const(0)  # projected centre, + BIAS
CIRCLE_Y_Q8 = const(1)
CIRCLE_RADIUS_Q8 = const(2)  # outer ring, 1024..24576
CIRCLE_E1 = const(3)  # ellipse * 2**14, within +-4096, + BIAS
CIRCLE_E2 = const(4)
CIRCLE_HX = const(5)  # perspective, likewise
CIRCLE_HY = const(6)
CIRCLE_WIDTH = const(7)  # of the frame
CIRCLE_HEIGHT = const(8)
CIRCLE_ITEMS = const(9)

# FAN, directions from the centre, and the units of radius looked at in each
FAN_DIRECTIONS = const(0)
FAN_STEP = const(1)  # between them, 1/256 turn
FAN_START = const(2)  # the first of them, 1/256 turn
FAN_FIRST = const(3)  # unit
FAN_COUNT = const(4)  # of units; first + count <= 48
FAN_ITEMS = const(5)

# ZONE, some of a fan's units; several lie in one array
ZONE_FIRST = const(0)  # after the fan's first
ZONE_COUNT = const(1)
ZONE_SLOT = const(2)  # the zone's first item in what is made of it
ZONE_ITEMS = const(3)

# SCAN, a coarse look at a candidate (polar.circle_samples), 1/256 px
SCAN_FIRST = const(0)  # distances from the centre: first,
SCAN_PITCH = const(1)  # step,
SCAN_COUNT = const(2)  # number
SCAN_LEAST = const(3)  # outer radii to try
SCAN_LAST = const(4)
SCAN_REFERENCE = const(5)  # radius from which shifts are counted
SCAN_ITEMS = const(6)

# LIGHT, what the eight positions tell of light and noise (code_rules.code_light)
LIGHT_LEVEL = const(0)  # mean brightness, log units;
LIGHT_THIRD = const(1)  # of the third brightest
LIGHT_GUARD = const(2)  # largest area of both halves where no line is,
LIGHT_STRAY = const(3)  # largest that is stray, of either sign, below the mean of the sides,
LIGHT_STRAY_HALF = const(4)  # and of one half
LIGHT_ROUGH = const(5)  # median roughness where no bit is
LIGHT_ITEMS = const(6)

# ROBUST, one fit of both rings' sectors at once (kernels.robust); sectors: 16 outer, 16 inner ones
ROBUST_SHIFTS = const(0)  # 32: mean residual of each sector, 1/1024 px + 32768; 0 where there is none
ROBUST_BASES = const(32)  # 32: weight by depth, 0..64
ROBUST_WEIGHTS = const(64)  # 32: the same times that by distance from the fit
ROBUST_LEFT = const(96)  # 32: what the fit leaves, 1/1024 px, + BIAS
ROBUST_PARAMETERS = const(128)  # 8, 1/16384 px, + BIAS
ROBUST_MATRIX = const(136)  # 8 x 8: lower triangle, 256 = a full sector, + BIAS; later its factors
ROBUST_RIGHT = const(200)  # 8: right hand side, + BIAS; scratch space
ROBUST_MOMENTS = const(208)  # 2 x 14: weighted sums over a ring, + BIAS
ROBUST_SCALE = const(236)  # spread of what is left, 1/1024 px
ROBUST_USED = const(237)  # sum of the weights, 64 = a full sector
ROBUST_SQUARE = const(238)  # sum of the weighted squares of what is left, / 64
ROBUST_ITEMS = const(239)

# CANDIDATE, a place that the blur-model reader may look at (blurred.candidates)
CANDIDATE_RANK = const(0)  # how far it came
CANDIDATE_X_Q8 = const(1)  # centre and range of radii where the search found it
CANDIDATE_Y_Q8 = const(2)
CANDIDATE_LEAST_Q8 = const(3)
CANDIDATE_MOST_Q8 = const(4)
CANDIDATE_VERDICT = const(5)  # what the direct reader said
CANDIDATE_LOOKED = const(6)  # whether there was a coarse look,
CANDIDATE_SCORE = const(7)  # how much it looks like rings, and the rings' coarse pose
CANDIDATE_X_Q10 = const(8)
CANDIDATE_Y_Q10 = const(9)
CANDIDATE_RADIUS_Q8 = const(10)
CANDIDATE_E1 = const(11)
CANDIDATE_E2 = const(12)
CANDIDATE_KIND = const(13)  # how the last examination of its place ended (blurred.places)
CANDIDATE_ITEMS = const(14)

# CLOCK, the vehicle's clock in terms of the camera's (locate.vehicle_clock, kernels.odometry)
CLOCK_KNOWN = const(0)
CLOCK_OFFSET_US = const(1)
CLOCK_REST_NS = const(2)
CLOCK_HEARD_US = const(3)
CLOCK_DRIFT_PPM = const(4)
CLOCK_HAS_LAST = const(5)  # the earliest message of the span before
CLOCK_LAST_US = const(6)  # when it came,
CLOCK_LAST_OFFSET_US = const(7)  # what it told of the clocks,
CLOCK_LAST_WAITED_US = const(8)  # how long it may have waited
CLOCK_SPAN_MS = const(9)
CLOCK_BEGAN_US = const(10)
CLOCK_BEGAN_OFFSET_US = const(11)
CLOCK_MESSAGES = const(12)
CLOCK_EARLIEST_US = const(13)
CLOCK_EARLIEST_OFFSET_US = const(14)
CLOCK_WAITED_US = const(15)
CLOCK_LEAST_US = const(16)  # by which a message was late, against the span's beginning and the drift
CLOCK_LATE_US = const(17)  # ... against the estimate
CLOCK_ARRIVED_US = const(18)  # the message that is heard
CLOCK_SENT_US = const(19)
CLOCK_READ_US = const(20)  # for how long it may have waited to be read
CLOCK_ITEMS = const(21)

# TREND, the slope of what odometry leaves out over what it tells (locate.odometry_shares);
# signed without BIAS
TREND_MOMENT = const(0)  # sum of told * missed by variance / 16, in 2**-fine
TREND_WEIGHT = const(1)  # of told**2
TREND_FINE = const(2)  # bits behind the point, 0..6
TREND_PRIOR_Q20 = const(3)
TREND_PRIOR_SIGMA_Q20 = const(4)
TREND_PRIOR_WEIGHT = const(5)  # 0..2**20
TREND_VALUE_Q20 = const(6)  # what `settle` finds
TREND_SIGMA_Q20 = const(7)
TREND_ITEMS = const(8)

# ROLLING, how a vehicle moves and a rolling shutter exposes, and a marker put right (locate.rolling)
ROLLING_DX = const(0)  # driven since the frame before, odometry frame, 0.1 mm,
ROLLING_DY = const(1)
ROLLING_PASSED_MS = const(2)  # in so long
ROLLING_TURN = const(3)  # 0.01 degrees/s
ROLLING_TOLD = const(4)  # the heading in the middle between the frames
ROLLING_ROW = const(5)  # 16 ns
ROLLING_SHEAR = const(6)
ROLLING_DOWN_X = const(7)  # the direction of the rows, Q14
ROLLING_DOWN_Y = const(8)
ROLLING_X = const(9)  # of the marker, vehicle frame, 0.1 mm
ROLLING_Y = const(10)
ROLLING_HEADING = const(11)  # 0.01 degrees
ROLLING_LAST_US = const(12)  # of the frame before, and where odometry was
ROLLING_LAST_X = const(13)
ROLLING_LAST_Y = const(14)
ROLLING_LAST_HEADING = const(15)
ROLLING_ITEMS = const(16)

# COVARIANCE, of a pose that odometry carries on (locate.carrier, kernels.covariance)
COVARIANCE_XX = const(0)  # mm2 Q4
COVARIANCE_XY = const(1)
COVARIANCE_YY = const(2)
COVARIANCE_XT = const(3)  # of place and heading, mm mrad Q5
COVARIANCE_YT = const(4)
COVARIANCE_TT = const(5)  # mrad2 Q8
COVARIANCE_SCALE = const(6)  # what the scale has made of the way so far, mm Q4
COVARIANCE_TURNS = const(7)  # what drift and turn have made of the heading, mrad2 Q8
COVARIANCE_BENT_X = const(8)  # by how much shorter headings that are wrong make the way, mm Q8
COVARIANCE_BENT_Y = const(9)
COVARIANCE_SCALE_SIGMA = const(10)  # of odometry_shares.OdometryShares, Q20
COVARIANCE_DRIFT_SIGMA = const(11)
COVARIANCE_TURN_SIGMA = const(12)
COVARIANCE_NOISE_Q4 = const(13)  # of uncertainty.OdometryNoise: noise_q4, speed_noise_us, track_q4
COVARIANCE_HASTE_US = const(14)
COVARIANCE_TRACK_Q4 = const(15)
COVARIANCE_SIGMA_X = const(16)  # 0.1 mm
COVARIANCE_SIGMA_Y = const(17)
COVARIANCE_SIGMA_CDEG = const(18)
COVARIANCE_CORRELATION = const(19)  # of x and y, Q14
COVARIANCE_ITEMS = const(20)

# PATH, of the vehicle since a marker, as odometry carries it on (locate.carrier, kernels.odometry)
PATH_HEADING_Q6 = const(0)  # of the vehicle, 0.01 degrees
PATH_X = const(1)  # since the marker, 0.1 mm Q4
PATH_Y = const(2)
PATH_NEW_X = const(3)  # since the covariance grew
PATH_NEW_Y = const(4)
PATH_WAY = const(5)  # since the marker, turns of wheels counted, 0.1 mm
PATH_SINCE = const(6)  # since the covariance grew
PATH_TURNED = const(7)  # since the marker, 0.01 degrees
PATH_TURNED_MOST = const(8)  # to either side
PATH_SPEED = const(9)  # of the last increment, mm/s
PATH_SCALE_Q12 = const(10)  # what odometry leaves out: OdometryShares
PATH_TURN_Q14 = const(11)
PATH_DRIFT_Q16 = const(12)
PATH_HALF_TRACK = const(13)  # mm
PATH_ITEMS = const(14)

# SUMS, what odometry told since a marker or a while ago (locate.odometry_shares)
SUMS_FORWARD = const(0)  # 0.1 mm
SUMS_DRIVEN = const(1)  # to and fro
SUMS_WAY = const(2)  # turns of wheels counted
SUMS_TURNED = const(3)  # 0.01 degrees
SUMS_ITEMS = const(4)
