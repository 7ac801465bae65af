/* LARICS camera: the wire. Reads the camera's stream and makes commands. C99, no allocation.
 *
 *     larics_decoder decoder;              one for each line
 *     larics_decoder_init(&decoder);
 *     for each byte received:
 *         if (larics_decode(&decoder, byte)) ... decoder.message ...
 *
 * Whatever is not a whole message with the right CRC and all fields within their ranges changes nothing
 * but a counter. Whether a message may be steered by is for larics_supervisor.h to judge. Units are in the
 * names: _mm10 is 0.1 mm, _cdeg 0.01 degree, _q8 1/256 pixel. The vehicle frame has x forward, y left, z up;
 * angles count counterclockwise as seen from above.
 */
#ifndef LARICS_H
#define LARICS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LARICS_LIMIT 128     /* bytes of the longest message with header and CRC */
#define LARICS_MAX_FRAME 130 /* bytes of the longest frame on the line */

/* generated: begin (tools/make_protocol.py) */
#define LARICS_VERSION 1
#define LARICS_COUNT_MAX 0x3FFFFFFFu /* counters wrap to 0 after it */
#define LARICS_FIRST_COMMAND 64
#define LARICS_SETTING_VALUES 8
#define LARICS_RAW_CHUNK_BYTES 64
#define LARICS_MARKER_FRAME 45 /* bytes of a MARKER on the line */

/* larics_message.type */
#define LARICS_INFO 1
#define LARICS_MARKER 2
#define LARICS_POSE 3
#define LARICS_STATUS 4
#define LARICS_ACK 5
#define LARICS_NACK 6
#define LARICS_SETTING 7
#define LARICS_RAW_HEADER 8
#define LARICS_RAW_CHUNK 9
#define LARICS_MOTION 10
#define LARICS_GET_INFO 64
#define LARICS_PING 65
#define LARICS_GET_SETTING 66
#define LARICS_SET_SETTING 67
#define LARICS_SAVE_SETTINGS 68
#define LARICS_GET_RAW 69
#define LARICS_GET_RAW_AGAIN 70
#define LARICS_RESTART 71
#define LARICS_ODOMETRY 72

/* MARKER flag */
#define LARICS_MARKER_ID_UNCERTAIN 1 /* pose certain, ID not: id is 65535 */
#define LARICS_MARKER_UNCONFIRMED 2 /* ID not yet agreed on by enough frames */
#define LARICS_MARKER_TRACKED 4 /* found around the prediction, without a search */
#define LARICS_MARKER_BORDER 8 /* plate cut off by the border of the frame */
#define LARICS_MARKER_MODEL 16 /* accepted by the blur-model reader, not by the direct reader */
#define LARICS_MARKER_NONE 32 /* no marker seen in this frame: count 0, id 65535, measures 0 */
#define LARICS_MARKER_NO_OFFSET 64 /* x, y, z unknown and 0: the camera is not calibrated */

/* POSE state */
#define LARICS_LOST 0 /* no usable pose; x, y, heading and sigma are unknown */
#define LARICS_COASTING 1 /* predicted from earlier markers */
#define LARICS_TRACKING 2 /* measured in this frame */
#define LARICS_CARRIED 3 /* carried on by the vehicle's odometry from earlier markers */

/* MOTION state */
#define LARICS_MOTION_NONE 0 /* no odometry for this frame; the other fields tell the last one */
#define LARICS_MOTION_INTERPOLATED 1 /* between two ODOMETRY messages */
#define LARICS_MOTION_EXTRAPOLATED 2 /* after the last one */

/* ODOMETRY flag */
#define LARICS_ODOMETRY_SLIP 1 /* the vehicle suspects that a wheel slips */
#define LARICS_ODOMETRY_STANDING 2 /* the vehicle stands, and knows it */

/* Special value */
#define LARICS_ID_NONE 65535 /* id: none, or uncertain */
#define LARICS_ROUTE_NONE 65535 /* route_position: no route, or not on it */
#define LARICS_DIRECTION_NONE 36000 /* next_cdeg: no next direction */
#define LARICS_SIGMA_UNKNOWN 65535 /* sigma: unknown or larger than can be told */
#define LARICS_AGE_UNKNOWN 65535 /* marker_age_ms: no marker yet, or older than can be told */
#define LARICS_WAY_UNKNOWN 65535 /* way_mm: no odometry, or longer than can be told */
#define LARICS_PLACE_UNKNOWN -1073741823 /* x, y of POSE: LOST */
#define LARICS_HEADING_UNKNOWN 36000 /* heading of POSE: LOST */
#define LARICS_TIME_UNKNOWN 1073741823 /* times of STATUS: no frame in this second, or longer */
#define LARICS_RATE_UNKNOWN 65535 /* rate: no second has passed yet */
#define LARICS_GREY_UNKNOWN 65535 /* grey_mean: no frame yet */

/* GET_RAW window */
#define LARICS_RAW_WHOLE 0 /* the whole frame */
#define LARICS_RAW_MARKERS 1 /* around the markers found in it; the whole frame without one */

/* RAW_CHUNK coding */
#define LARICS_RAW_PLAIN 8 /* bytes as they are, at most 64; 0..7 are Rice parameters */

/* NACK reason */
#define LARICS_NACK_UNKNOWN_KEY 1 /* no setting has this key */
#define LARICS_NACK_RANGE 2 /* a value is outside its range */
#define LARICS_NACK_LENGTH 3 /* wrong number of values for this setting */
#define LARICS_NACK_LIST_ORDER 4 /* a list's parts came out of order: start again at first 0 */
#define LARICS_NACK_CONFLICT 5 /* valid alone, but not together with other settings */
#define LARICS_NACK_STORAGE 6 /* the settings could not be written; the old file is kept */
#define LARICS_NACK_BUSY 7 /* not now: try again */
#define LARICS_NACK_NO_FRAME 8 /* no frame yet, or no memory for a copy of it */
#define LARICS_NACK_TRANSFER 9 /* this raw frame is not kept any more */
#define LARICS_NACK_PIXELS 10 /* this raw frame has no such pixels */
#define LARICS_NACK_TOKEN 11 /* this token was just used for another command */
#define LARICS_NACK_BOOT 12 /* the boot number is not the current one: already restarted */
#define LARICS_NACK_UNKNOWN_COMMAND 13 /* this firmware does not have this command */
#define LARICS_NACK_MEMORY 14 /* the board has no memory for this value; the one before is in use */

/* Fault */
#define LARICS_FAULT_CAMERA_TIMEOUT 1 /* no frame within the time limit */
#define LARICS_FAULT_CAMERA_RESET 2 /* the camera was started again */
#define LARICS_FAULT_UART_WRITE 3 /* the line took fewer bytes than given, or none */
#define LARICS_FAULT_SETTINGS_MISSING 4 /* no settings file: defaults in use */
#define LARICS_FAULT_SETTINGS_CORRUPT 5 /* settings file damaged: the previous one in use, or defaults */
#define LARICS_FAULT_SETTINGS_VERSION 6 /* settings of another version: what is valid is used */
#define LARICS_FAULT_STORAGE 7 /* flash full or read-only */
#define LARICS_FAULT_DETECT 8 /* exception in the detection of a frame */
#define LARICS_FAULT_MEMORY 9 /* memory ran out; while it lasts: no second opinion, rings from 15 or 22 px, or no detector */
#define LARICS_FAULT_SAVE_INTERRUPTED 10 /* power lost while saving: previous settings in use */
#define LARICS_FAULT_WATCHDOG 11 /* started by the watchdog */
#define LARICS_FAULT_SAFE_MODE 12 /* safe mode: three fast resets, or the button */
#define LARICS_FAULT_CAMERA 13 /* the camera driver reported an error */
#define LARICS_FAULT_COMMAND 14 /* a command ended in an exception */
#define LARICS_FAULT_LOOP 15 /* exception outside of camera, detection and commands */
#define LARICS_FAULT_MARKER_UNKNOWN 16 /* a marker that is not in the map */
#define LARICS_FAULT_MARKER_HEIGHT 17 /* a marker whose size contradicts its height */
#define LARICS_FAULT_MARKER_PLACE 18 /* a marker where it cannot be: misread, moved, or the vehicle was moved */
#define LARICS_FAULT_ROUTE 19 /* a wrong, missing or unexpected marker on the route */
#define LARICS_FAULT_CAMERA_FROZEN 20 /* the camera serves the same picture again and again */
#define LARICS_FAULT_CAMERA_DARK 21 /* nothing but black: no light, or the lens is covered */
#define LARICS_FAULT_CAMERA_WHITE 22 /* nothing but white: far too much light */
#define LARICS_FAULT_ODOMETRY 23 /* odometry contradicts the markers (unit, sign, axis?): it is ignored */

/* keys of the settings */
#define LARICS_KEY_WIDTH 1
#define LARICS_KEY_HEIGHT 2
#define LARICS_KEY_FOCAL_Q8 3
#define LARICS_KEY_CENTER_X_Q8 4
#define LARICS_KEY_CENTER_Y_Q8 5
#define LARICS_KEY_K1_E5 6
#define LARICS_KEY_K2_E5 7
#define LARICS_KEY_MOUNT_CDEG 8
#define LARICS_KEY_MIRRORED 9
#define LARICS_KEY_TILT_FORWARD_CDEG 10
#define LARICS_KEY_TILT_LEFT_CDEG 11
#define LARICS_KEY_CAMERA_X_MM10 12
#define LARICS_KEY_CAMERA_Y_MM10 13
#define LARICS_KEY_CAMERA_Z_MM10 14
#define LARICS_KEY_CEILING_MM10 15
#define LARICS_KEY_METHOD 19
#define LARICS_KEY_RADIUS_MIN_PX 20
#define LARICS_KEY_RADIUS_MAX_PX 21
#define LARICS_KEY_OUTER_MM10 22
#define LARICS_KEY_LINE_MM10 23
#define LARICS_KEY_FAMILY 18
#define LARICS_KEY_ALLOWED_IDS 24
#define LARICS_KEY_ALLOW_ID0 25
#define LARICS_KEY_TRACKING 26
#define LARICS_KEY_SECOND_OPINION 27
#define LARICS_KEY_CONFIRM_NEEDED 28
#define LARICS_KEY_CONFIRM_FRAMES 29
#define LARICS_KEY_MAX_TILT_CDEG 30
#define LARICS_KEY_MAX_SPEED_MM_S 31
#define LARICS_KEY_MARGIN_MIN 32
#define LARICS_KEY_BAUD 40
#define LARICS_KEY_OUTPUT 41
#define LARICS_KEY_RATE_DIVIDER 42
#define LARICS_KEY_MAVLINK_SYSTEM 43
#define LARICS_KEY_MAVLINK_COMPONENT 44
#define LARICS_KEY_MAVLINK_TARGET 45
#define LARICS_KEY_EXPOSURE 50
#define LARICS_KEY_EXPOSURE_US 51
#define LARICS_KEY_EXPOSURE_MAX_US 52
#define LARICS_KEY_GAIN_DB10 53
#define LARICS_KEY_GAIN_MAX_DB10 54
#define LARICS_KEY_BLUR_MAX_Q8 55
#define LARICS_KEY_TARGET_GREY 56
#define LARICS_KEY_ROUTE 60
#define LARICS_KEY_MAP 61
#define LARICS_KEY_MAP_SIGMA_MM10 70
#define LARICS_KEY_MAP_SIGMA_CDEG 71
#define LARICS_KEY_FOCAL_SIGMA_PPM 72
#define LARICS_KEY_HEIGHT_SIGMA_MM10 73
#define LARICS_KEY_TILT_SIGMA_CDEG 74
#define LARICS_KEY_MOUNT_SIGMA_CDEG 75
#define LARICS_KEY_CAMERA_SIGMA_MM10 76
#define LARICS_KEY_ODOMETRY_SCALE_PPM 80
#define LARICS_KEY_ODOMETRY_TURN_PPM 81
#define LARICS_KEY_ODOMETRY_DRIFT_MDEG_M 82
#define LARICS_KEY_ODOMETRY_SCALE_SIGMA_PPM 83
#define LARICS_KEY_ODOMETRY_TURN_SIGMA_PPM 84
#define LARICS_KEY_ODOMETRY_DRIFT_SIGMA_MDEG_M 85
#define LARICS_KEY_ODOMETRY_NOISE_MM2_KM 86
#define LARICS_KEY_ODOMETRY_SPEED_NOISE_US 87
#define LARICS_KEY_ODOMETRY_TRACK_MM 88
#define LARICS_KEY_ROW_NS 89

/* who is speaking: at start and as answer to GET_INFO */
typedef struct {
    uint16_t token; /* of GET_INFO; 0 at start */
    uint16_t boot; /* drawn at random at each start; RESTART needs it */
    uint8_t version_major; /* version of the firmware */
    uint8_t version_minor; /* version of the firmware */
    uint8_t version_patch; /* version of the firmware */
    uint16_t width; /* frame width, px */
    uint16_t height; /* frame height, px */
    uint8_t settings; /* highest key of a setting */
    uint8_t board[16]; /* board name, ASCII, padded with 0 */
    uint8_t unique_id[12]; /* unique ID of the processor, padded with 0 */
} larics_info;

/* one marker in one processed frame; sent with count 0 when the frame has none */
typedef struct {
    uint32_t frame; /* number of the camera frame, wraps to 0 after 2**30 - 1 */
    uint32_t age_us; /* from the middle of the exposure to the start of sending, us */
    uint16_t flags; /* sum of MARKER flags; others may follow and are ignored */
    uint16_t id; /* marker ID, or 65535 for none or uncertain */
    uint8_t index; /* which of the markers of this frame, 0..count-1; 0 when count is 0; 0..254 */
    uint8_t count; /* number of markers in this frame */
    int32_t x_mm10; /* marker centre minus vehicle origin, forward, 0.1 mm; -1000000..1000000 */
    int32_t y_mm10; /* the same, to the left, 0.1 mm; -1000000..1000000 */
    int32_t z_mm10; /* the same, up, 0.1 mm; -1000000..1000000 */
    uint16_t heading_cdeg; /* orientation line, vehicle frame, ccw from above, 0.01 deg; 0..35999 */
    uint8_t margin; /* how far the weakest decision is from its limit */
    uint16_t radius_q8; /* outer ring in the image; 65535 for that and more, 1/256 px */
    uint16_t sigma_q12; /* standard deviation of the centre; 65535 unknown, 1/4096 px */
    uint16_t sigma_mdeg; /* standard deviation of the heading; 65535 unknown, 0.001 deg */
} larics_marker;

/* the vehicle in the map, once for each processed frame when there is a map */
typedef struct {
    uint32_t frame; /* number of the camera frame, wraps to 0 after 2**30 - 1 */
    uint32_t age_us; /* from the middle of the exposure to the start of sending, us */
    uint16_t marker_age_ms; /* since the last marker it rests on; 65535 none, or more, ms */
    uint8_t state; /* POSE state; 0..3 */
    uint16_t id; /* that marker, 65535 for none */
    int32_t x_mm10; /* vehicle origin, map frame; unknown when LOST, 0.1 mm */
    int32_t y_mm10; /* vehicle origin, map frame; unknown when LOST, 0.1 mm */
    uint16_t heading_cdeg; /* vehicle's x axis, map frame, ccw; 36000 unknown, 0.01 deg; 0..36000 */
    uint16_t sigma_x_mm10; /* standard deviation of x; 65535 unknown, 0.1 mm */
    uint16_t sigma_y_mm10; /* standard deviation of y; 65535 unknown, 0.1 mm */
    int16_t correlation_q14; /* of the errors of x and y; 0 if unknown, 1/16384; -16384..16384 */
    uint16_t sigma_cdeg; /* standard deviation of the heading; 65535 unknown, 0.01 deg */
    uint16_t way_mm; /* driven since that marker, by odometry; 65535 unknown, or more, mm */
    uint16_t route_position; /* index in the route of the marker reached; 65535 none */
    uint16_t next_cdeg; /* direction to go on, vehicle frame; 36000 none, 0.01 deg; 0..36000 */
} larics_pose;

/* health, once a second; counters since start */
typedef struct {
    uint8_t version_major; /* version of the firmware */
    uint8_t version_minor; /* version of the firmware */
    uint8_t version_patch; /* version of the firmware */
    uint16_t boot; /* as in INFO */
    uint32_t uptime_s; /* time since start, s */
    uint32_t frames; /* frames processed */
    uint32_t missed; /* camera frames not processed, because a newer one was there */
    uint32_t detections; /* markers reported */
    uint32_t rejects; /* candidates refused */
    uint32_t drops; /* measurements replaced by newer ones before they were sent */
    uint32_t crc_errors; /* received frames with a wrong CRC */
    uint32_t line_errors; /* received frames refused for any other reason */
    uint32_t faults; /* number of faults */
    uint8_t last_fault; /* code of the last fault, 0 for none */
    uint32_t active_faults; /* faults that last: bit n stands for code n */
    uint8_t state; /* POSE state; without a map, of the marker; 0..3 */
    uint32_t exposure_us; /* exposure time, us */
    uint16_t gain_cdb; /* camera gain, 0.01 dB */
    uint16_t grey_mean; /* mean grey of the last frame, 0..255; 65535 without one */
    uint16_t rate_chz; /* frames processed a second; 65535 not yet known, 0.01 Hz */
    uint32_t frame_us; /* mean time from frame to frame in this second, if any, us */
    uint32_t detect_us; /* mean time of a detection in this second, if any, us */
    uint32_t latency_us; /* longest time from capture to sending of it, if any, us */
    uint32_t free_bytes; /* free heap after a collection, measured each 30 s */
    uint32_t unanswered; /* commands left unanswered, because too many came at once */
    uint32_t clamped; /* values reported as the nearest that their field can hold */
    uint32_t odometry_used; /* ODOMETRY messages taken into use */
    uint32_t odometry_refused; /* those that came twice or out of order */
    uint32_t odometry_stale; /* those that came too late to be of use */
    uint32_t odometry_jumps; /* times that it began anew: reset, jump, other clock */
} larics_status;

/* the command was carried out; after the data it asked for */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
    uint8_t command; /* type number of the command */
} larics_ack;

/* the command was refused and changed nothing */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
    uint8_t command; /* type number of the command */
    uint8_t reason; /* NACK reason */
    uint8_t detail; /* key of the setting in question, else 0 */
} larics_nack;

/* up to eight values of one setting: answer to GET_SETTING */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
    uint8_t key; /* number of the setting */
    uint16_t first; /* index of value0 within a list; 0 for single values */
    uint16_t count; /* length of the whole list; 1 for single values */
    int32_t value[LARICS_SETTING_VALUES]; /* value of index first + k; 0 where there is none */
} larics_setting;

/* what the raw frame is, or the window of it, whose chunks follow */
typedef struct {
    uint16_t token; /* of GET_RAW; names the transfer */
    uint32_t frame; /* number of the camera frame, wraps to 0 after 2**30 - 1 */
    uint16_t width; /* frame width, px; 1..65535 */
    uint16_t height; /* frame height, px; 1..65535 */
    uint16_t left; /* first column of the window, px */
    uint16_t top; /* first row of the window, px */
    uint16_t columns; /* width of the window; that of the frame when it is whole, px; 1..65535 */
    uint16_t rows; /* height of the window, px; 1..65535 */
    uint16_t crc_low; /* CRC-32 of the window's pixels row by row, low half */
    uint16_t crc_high; /* CRC-32 of the window's pixels, high half */
} larics_raw_header;

/* pixels of a raw frame, packed without loss; sent when the line is otherwise idle */
typedef struct {
    uint16_t token; /* of GET_RAW */
    uint32_t first; /* number of the first pixel, in strips of 16 columns */
    uint16_t count; /* number of pixels; 1..505 */
    uint8_t coding; /* Rice parameter 0..7, or 8: plain bytes; 0..8 */
    uint8_t data[64]; /* the pixels; 0 after the last one */
} larics_raw_chunk;

/* the vehicle's odometry at the exposure of a processed frame, as the camera used it; once it has any */
typedef struct {
    uint32_t frame; /* number of the camera frame, wraps to 0 after 2**30 - 1 */
    uint8_t state; /* MOTION state; 0..2 */
    uint8_t epoch; /* of the ODOMETRY used */
    int32_t x_mm10; /* odometry frame, in the middle of the exposure, 0.1 mm; -536870911..536870911 */
    int32_t y_mm10; /* the same, to the left, 0.1 mm; -536870911..536870911 */
    uint16_t heading_cdeg; /* the same, counterclockwise, 0.01 deg; 0..35999 */
    uint32_t way_mm10; /* driven since the start, to and fro, wraps to 0, 0.1 mm */
    uint32_t turn_cdeg; /* turned since the start, to and fro, wraps to 0, 0.01 deg */
    uint32_t odometry_age_us; /* from the newest odometry to the exposure; 0: none, us */
} larics_motion;

/* answered by INFO, then ACK */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
} larics_get_info;

/* answered by ACK */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
} larics_ping;

/* answered by SETTING, one for each eight values, then ACK */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
    uint8_t key; /* number of the setting */
} larics_get_setting;

/* up to eight values; a list takes effect with its last part */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
    uint8_t key; /* number of the setting */
    uint16_t first; /* index of value0 within a list; 0 for single values */
    uint16_t count; /* length of the whole list; 1 for single values */
    int32_t value[LARICS_SETTING_VALUES]; /* value of index first + k; 0 where there is none */
} larics_set_setting;

/* writes all settings to flash */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
} larics_save_settings;

/* answered by RAW_HEADER and ACK, then all RAW_CHUNKs */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
    uint8_t window; /* window of the frame; 0..1 */
} larics_get_raw;

/* sends pixels again, of the frame still kept */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
    uint16_t transfer; /* token of the GET_RAW */
    uint32_t first; /* number of the first pixel, as in RAW_CHUNK */
    uint32_t count; /* number of pixels; 1..1073741823 */
} larics_get_raw_again;

/* restarts after its ACK was sent */
typedef struct {
    uint16_t token; /* returned by the answer; a retry repeats it, a new command does not */
    uint16_t boot; /* from INFO or STATUS, so that a retry cannot restart twice */
} larics_restart;

/* where the vehicle is by its wheels, up to 100 times a second; not answered */
typedef struct {
    uint32_t time_us; /* when it was sampled, on the vehicle's clock; wraps to 0, us */
    uint32_t age_us; /* from then to the start of sending, us */
    int32_t x_mm10; /* odometry frame; cumulative since its start, 0.1 mm; -536870911..536870911 */
    int32_t y_mm10; /* the same, to the left, 0.1 mm; -536870911..536870911 */
    uint16_t heading_cdeg; /* vehicle's x axis in that frame, counterclockwise, 0.01 deg; 0..35999 */
    uint8_t epoch; /* another one after each jump or reset of x, y, heading or time_us */
    uint8_t flags; /* sum of ODOMETRY flags; others may follow and are ignored */
} larics_odometry;

typedef struct {
    uint8_t type;
    uint16_t sequence;
    union {
        larics_info info;
        larics_marker marker;
        larics_pose pose;
        larics_status status;
        larics_ack ack;
        larics_nack nack;
        larics_setting setting;
        larics_raw_header raw_header;
        larics_raw_chunk raw_chunk;
        larics_motion motion;
        larics_get_info get_info;
        larics_ping ping;
        larics_get_setting get_setting;
        larics_set_setting set_setting;
        larics_save_settings save_settings;
        larics_get_raw get_raw;
        larics_get_raw_again get_raw_again;
        larics_restart restart;
        larics_odometry odometry;
    } as;
} larics_message;
/* generated: end */

/* What a decoder met. Each frame that ends counts in exactly one of the first nine. */
typedef struct {
    uint32_t messages;     /* delivered */
    uint32_t crc;          /* wrong checksum */
    uint32_t cobs;         /* ended in the middle of a block */
    uint32_t length;       /* too short, or not as long as its type */
    uint32_t version;      /* of another version */
    uint32_t unknown;      /* of an unknown type */
    uint32_t over_long;    /* longer than any message */
    uint32_t empty;        /* a 0 right after a 0 */
    uint32_t out_of_range; /* a field outside its range */
    uint32_t gaps;         /* messages missing by their sequence numbers */
    uint32_t repeats;      /* the number before once more */
    uint32_t restarts;     /* times that the sender began to count anew */
} larics_counters;

typedef struct {
    larics_counters counters;
    larics_message message; /* valid after larics_decode returned 1, until its next call */
    uint32_t crc;           /* private from here on */
    uint16_t sequence;
    uint16_t boot;
    uint16_t doubtful;
    uint8_t has_sequence;
    uint8_t has_boot;
    uint8_t went_back;
    uint8_t state;
    uint8_t size;
    uint8_t left;
    uint8_t buffer[LARICS_LIMIT + 1];
} larics_decoder;

void larics_decoder_init(larics_decoder *decoder);

/* Takes one byte; 1 when decoder->message is a new message, else 0. */
int larics_decode(larics_decoder *decoder, uint8_t byte);

/* Puts `message`, numbered `sequence` (the caller counts up), into frame[0..result-1]. 0 when its type is
 * unknown or a field is out of its range: nothing must be sent then. */
size_t larics_encode(const larics_message *message, uint16_t sequence, uint8_t frame[LARICS_MAX_FRAME]);

/* Makes `message` an ODOMETRY to be sent now: where the wheels say that the vehicle is, in its own odometry frame
 * (0.1 mm; heading counterclockwise in 0.01 deg, any angle). sampled_us and now_us are of one clock that counts
 * microseconds and may wrap as uint32_t does (milliseconds * 1000u will do). The pose is cumulative: a lost
 * message costs nothing. Another epoch says that pose or clock begin anew. */
void larics_set_odometry(larics_message *message, uint32_t sampled_us, uint32_t now_us, int32_t x_mm10,
                         int32_t y_mm10, int32_t heading_cdeg, uint8_t epoch);

/* Bytes of a message of this type on the line, always the same; 0 for an unknown type. */
size_t larics_frame_size(uint8_t type);

#ifdef __cplusplus
}
#endif

#endif
