"""Each camera driver against a faithful stand-in of its module, on the interpreter it runs on."""

import sys

sys.path.insert(0, __file__.rsplit("/", 1)[0] + "/fakes")

import camera as camera_module  # noqa: E402
import csi  # noqa: E402
import sensor  # noqa: E402
from board_parts import Clock  # noqa: E402

from cameras import CameraError  # noqa: E402
from cameras.esp32 import EspCamera  # noqa: E402
from cameras.openmv_csi import CsiCamera  # noqa: E402
from cameras.openmv_sensor import SensorCamera  # noqa: E402


def refused(action, text):
    try:
        action()
    except CameraError as error:
        assert text in str(error), str(error)
        return
    raise AssertionError("no CameraError about " + text)


def csi_camera(width=320, height=240, **options):
    csi.world.__init__()
    clock = Clock()
    camera = CsiCamera(width, height, clock=clock, **options)
    return camera, csi.world, clock


def test_csi_sets_exposure_last_and_reports_what_the_sensor_took():
    camera, world, _ = csi_camera(exposure_us=20000, gain_cdb=1000)
    camera.start()
    assert world.calls[0] == "reset" and world.calls[-1] == "auto_exposure"
    assert world.calls.index("framesize") < world.calls.index("framebuffers") < world.calls.index("settle")
    assert camera.exposure() == 20000
    assert camera.exposure(99999) == 30000  # the sensor's own limit
    assert camera.gain(1000) == 975  # its steps


def test_csi_never_waits_and_delivers_without_copying():
    camera, world, _ = csi_camera()
    camera.start()
    assert not camera.grab()
    world.complete()
    assert camera.grab() and camera.frame_number == 0 and camera.frame[0] == world.image_value
    first = camera.frame
    assert not camera.grab()
    world.complete()
    assert camera.grab() and camera.frame is first and first[0] == world.image_value


def test_csi_counts_skipped_frames_and_times_the_exposure():
    camera, world, clock = csi_camera(exposure_us=4000, readout_us=2000)
    camera.start()
    clock.now_us += 100000
    complete_us = clock.ticks_us()
    world.complete()
    clock.now_us += 30000  # fetched late
    assert camera.grab()
    assert clock.ticks_diff(complete_us, camera.capture_us) == 2000 + 2000
    world.complete(4)
    assert camera.grab() and camera.frame_number == 4 and camera.skipped == 3


def test_csi_asks_only_for_sizes_that_every_board_takes():
    camera, world, _ = csi_camera(360, 296)
    world.refused_sizes = ("custom",)
    camera.start()
    world.complete()
    assert camera.grab() and len(camera.frame) == 360 * 296
    camera, world, _ = csi_camera()
    world.refused_sizes = (csi.QVGA,)
    refused(camera.start, "Frame size is not supported")
    refused(csi_camera(1400, 100)[0].start, "no frame size holds 1400x100")


def test_csi_another_size_than_wanted_is_noticed():
    camera, world, _ = csi_camera(360, 296)
    world.cut_px = (352, 288)
    refused(camera.start, "gives 352x288, not 360x296")


def test_csi_failures_and_restart():
    camera, world, _ = csi_camera()
    world.detected = False
    refused(camera.start, "Failed to detect")
    world.detected = True
    camera.start()
    world.fails = csi.TIMEOUT
    refused(camera.grab, "timed out")
    world.fails = None
    camera.stop()
    assert camera.frame is None and world.callback is None and world.calls[-1] == "shutdown"
    camera.stop()
    camera.start()
    world.complete()
    assert camera.grab() and camera.frame_number == 0 and world.opened == 2


def test_csi_without_the_frame_interrupt():
    camera, world, clock = csi_camera(exposure_us=4000)
    camera.start()
    world.callback = None
    clock.now_us += 50000
    assert not camera.grab()
    world.complete()
    assert camera.grab() and clock.ticks_diff(clock.ticks_us(), camera.capture_us) == 2000


def test_the_age_is_never_told_too_small():
    """At 25 frames/s with 90 ms of detection: between its true value and so much more as the driver was not
    asked, and exact where an interrupt tells when the frame was complete."""
    for make, without in ((csi_camera, False), (csi_camera, True), (sensor_camera, True), (esp_camera, True)):
        camera, world, clock = make(exposure_us=6000, readout_us=1000)
        camera.start()
        if without and make is csi_camera:
            world.callback = None
        next_us, seen = clock.now_us + 40000, 0
        while seen < 20:
            clock.now_us += 500
            if clock.now_us >= next_us:
                world.complete()
                complete_us, next_us = clock.now_us, next_us + 40000
            if not camera.grab():
                continue
            true_us = clock.now_us - complete_us + 1000 + 3000
            told_us = clock.ticks_diff(clock.ticks_us(), camera.capture_us)
            most_us = 90500 if without else 0
            assert true_us <= told_us <= true_us + most_us, (make, seen, true_us, told_us)
            seen += 1
            for _ in range(180):  # the detection
                clock.now_us += 500
                if clock.now_us >= next_us:
                    world.complete()
                    complete_us, next_us = clock.now_us, next_us + 40000


def test_csi_takes_no_later_frame_for_the_one_it_got():
    camera, world, clock = csi_camera(exposure_us=4000, readout_us=2000)
    camera.start()
    world.complete()
    complete_us = clock.ticks_us()
    clock.now_us += 10000
    world.while_fetching = world.callback  # the interrupt of the next frame comes during the call
    assert camera.grab() and camera.frame_number == 0
    assert clock.ticks_diff(complete_us, camera.capture_us) == 2000 + 2000


def sensor_camera(width=320, height=240, **options):
    sensor.world.__init__()
    clock = Clock()
    camera = SensorCamera(width, height, clock=clock, **options)
    return camera, sensor.world, clock


def test_sensor_never_waits_while_frames_come():
    camera, world, clock = sensor_camera(360, 296, exposure_us=4000, readout_us=1000)
    camera.start()
    assert "framebuffers 3" in world.calls and camera.exposure() == 4000
    assert not camera.grab()
    world.complete()
    assert camera.grab() and len(camera.frame) == 360 * 296 and camera.frame[97] == world.image_value
    assert clock.ticks_diff(clock.ticks_us(), camera.capture_us) == 3000
    assert not camera.grab() and "blocking snapshot" not in world.calls


def test_sensor_starts_a_stalled_capture_again():
    camera, world, clock = sensor_camera()
    camera.start()
    clock.now_us += 250000
    assert camera.grab() and "blocking snapshot" in world.calls
    assert not camera.grab()
    world.fails = "Frame capture has timed out."
    clock.now_us += 250000
    refused(camera.grab, "timed out")


def test_sensor_exposure_gain_and_stop():
    camera, world, _ = sensor_camera()
    camera.start()
    assert camera.exposure(7000) == 7000 and camera.gain(600) == 600
    camera.stop()
    assert world.calls[-1] == "shutdown"


def esp_camera(width=320, height=240, **options):
    camera_module.world.__init__()
    clock = Clock()
    camera = EspCamera(width, height, clock=clock, **options)
    return camera, camera_module.world, clock


def test_esp_frames_are_unsigned_and_not_copied():
    camera, world, _ = esp_camera()
    camera.start()
    size, pixels, buffers, mode, _ = world.created[0]
    assert (size, pixels, buffers, mode) == (
        camera_module.FrameSize.QVGA,
        camera_module.PixelFormat.GRAYSCALE,
        2,
        camera_module.GrabMode.LATEST,
    )
    assert not camera.grab()
    world.image_value = 199
    world.complete()
    assert camera.grab() and camera.frame[5] == 200 and len(camera.frame) == 320 * 240
    world.memory[world.captures & 1][5] = 77
    assert camera.frame[5] == 77
    world.complete()
    assert camera.grab() and camera.frame[5] == 201 and camera.frame_number == 1


def test_esp_exposure_and_gain_in_the_sensors_steps():
    camera, world, clock = esp_camera(exposure_us=6000, gain_cdb=1200)
    camera.start()
    assert camera._camera.auto == [False, False]
    assert camera._camera.aec_value == 100 and camera.exposure() == 6000
    assert camera._camera.agc_gain == 3 and camera.gain() == 1204
    assert camera.exposure(10000000) == 72000 and camera.gain(9000) == 2983
    world.complete()
    assert camera.grab() and clock.ticks_diff(clock.ticks_us(), camera.capture_us) == 36000


def test_esp_failures():
    camera, world, _ = esp_camera(pins={"data_pins": [1, 2, 3]})
    refused(camera.start, "data_pins must have 8 elements")
    refused(esp_camera(333, 222)[0].start, "no frame size 333x222")
    camera, world, _ = esp_camera()
    world.detached = True
    refused(camera.start, "Failed to capture initial frame")
    world.detached = False
    camera.start()
    world.fails = True
    refused(camera.grab, "no frame could be captured")
    camera.stop()
    camera.stop()
    world.fails = False
    camera.start()
    world.complete()
    assert camera.grab() and camera.frame_number == 0
