"""Each trouble that the renderer knows does what it does in the world."""

from dataclasses import replace

import numpy as np
import pytest

from larics_host.render import PRESETS, painters
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.defects import Defects
from larics_host.render.drive import draw_drive
from larics_host.render.finish import Finish
from larics_host.render.flicker import Flicker
from larics_host.render.lens_dirt import Smear, look_through
from larics_host.render.painters import BOX, DISC, ROD
from larics_host.render.plates import Plate
from larics_host.render.processing import Processing
from larics_host.render.reflection import LowLamp
from larics_host.render.scene import Scene, Surface, item, table
from larics_host.render.sensor import Sensor
from larics_host.render.series import draw_view, generator
from larics_host.render.view import render_radiance, render_view

PLAIN = Surface(reflectance=0.6, speckle=0.0, stain=0.0)
CAMERA = Camera(focal_px=1200.0)  # 2.5 mm a pixel on a ceiling at 3 m; a marker in the middle
MM = 2.5
MIDDLE = (147.5, 179.5)
ROWS, COLUMNS = np.mgrid[:296, :360]
AWAY_MM = MM * np.hypot(ROWS - MIDDLE[0], COLUMNS - MIDDLE[1])


FLAT, STILL = Finish(), Motion()


def hang(finish=FLAT, marker_id=5, **scene):
    """A marker above the lens, its orientation line towards the top of the picture."""
    return Scene(surface=PLAIN, plates=(Plate(marker_id, Pose(0, 0, 0.0), finish=finish),), **scene)


def radiance(scene, camera=CAMERA, motion=STILL):
    return render_radiance(scene, Pose(), motion, camera)


def mirrored(finish, *rows, depth_mm=3000.0, **scene):
    """What lamps in a level plane add to the picture of a glossy plate."""
    lamps = tuple(LowLamp(row, depth_mm) for row in rows)
    return radiance(hang(finish, low_lamps=lamps, **scene)) - radiance(hang(finish, **scene))


GLOSSY = Finish(gloss=0.8)


def test_a_mirrored_lamp_adds_the_same_light_to_ink_and_paper_and_none_beside_the_plate():
    added = mirrored(GLOSSY, item(DISC, 0, 0, 5000, value=0.5))
    ink = np.abs(AWAY_MM - 150) < 4
    paper = np.abs(AWAY_MM - 125) < 8
    assert np.abs(added[ink] - 0.4).max() < 1e-3 and np.abs(added[paper] - 0.4).max() < 1e-3
    assert np.abs(added[AWAY_MM > 256]).max() < 1e-6
    assert np.abs(mirrored(Finish(), item(DISC, 0, 0, 5000, value=0.5))).max() == 0  # a matt plate


def test_light_goes_back_at_the_angle_at_which_it_came():
    """A lamp as deep as the lens is high appears at half of its distance; a sloping plate shifts it."""
    # the map's x is up in the picture, its y is to the right
    added = mirrored(GLOSSY, item(DISC, 120, 60, 30, value=1.0))
    weight = added / added.sum()
    up, right = (MIDDLE[0] - (weight * ROWS).sum()) * MM, ((weight * COLUMNS).sum() - MIDDLE[1]) * MM
    assert up == pytest.approx(60, abs=2) and right == pytest.approx(30, abs=2)
    added = mirrored(replace(GLOSSY, tilt=(0.02, 0.0)), item(DISC, 0, 0, 30, value=1.0))
    # 2 P - 2 depth slope = 0
    assert (MIDDLE[0] - (added * ROWS).sum() / added.sum()) * MM == pytest.approx(60, abs=2)


@pytest.mark.parametrize("curl_per_m", [0.2, -0.2])
def test_a_bent_plate_stretches_what_it_mirrors_across_the_bend(curl_per_m):
    finish = replace(GLOSSY, curl_per_m=curl_per_m, curl_deg=0.0)
    added = mirrored(finish, item(DISC, 0, 0, 80, value=1.0)) > 0.4
    along, across = np.ptp(ROWS[added]) * MM, np.ptp(COLUMNS[added]) * MM
    assert across == pytest.approx(80, abs=6)  # 1 + depth / height = 2 times smaller, as in a flat plate
    assert along == pytest.approx(160 / (2 - 2 * 3000 * curl_per_m / 1000), abs=8)


@pytest.mark.parametrize("soft_mm", [6.0, 120.0])
def test_reflections_have_hard_and_soft_edges(soft_mm):
    added = mirrored(GLOSSY, item(BOX, 0, 0, 200, 5000, value=1.0, soft_mm=soft_mm))
    profile = added[: int(MIDDLE[0]), 180][60:] / 0.8
    width = (
        np.interp(0.9, profile, np.arange(profile.size)) - np.interp(0.1, profile, np.arange(profile.size))
    ) * MM
    assert width == pytest.approx(max(0.61 * soft_mm / 2, 2), abs=2.5)


def test_what_hangs_before_the_plate_hides_what_it_mirrors():
    cable = table([item(ROD, 0, 0, 4000, 10, angle=np.pi / 2, value=0.2)])
    added = mirrored(GLOSSY, item(DISC, 0, 0, 5000, value=0.5), occluders=cable)
    assert abs(added[147, 180]) < 1e-6 and added[160, 180] == pytest.approx(0.4, abs=1e-3)


def test_a_bent_plate_keeps_its_centre_and_moves_its_rim():
    """Its sides hang nearer to the lens, so they are seen farther out."""
    beside, camera = Pose(-150.0, 0.0, 0.0), Camera(focal_px=900.0)
    flat, bent = (
        render_radiance(hang(Finish(curl_per_m=curl)), beside, STILL, camera) for curl in (0.0, 0.4)
    )
    top = [np.interp(0.8, image[:32, 180], np.arange(32)) for image in (flat, bent)]
    # 0.5 * 0.4e-3 / mm * 250 mm ** 2 = 12.5 mm of 3000 nearer, 400 mm from below the lens
    assert top[0] - top[1] == pytest.approx(400 * 12.5 / 3000 * 0.3, abs=0.1)
    near = np.hypot(ROWS - MIDDLE[0] + 45, COLUMNS - MIDDLE[1]) < 24  # the code around the centre
    assert np.abs(flat - bent)[near].max() < 0.03


def test_a_screen_prints_a_grey_of_its_tone_and_leaves_paper_white():
    ring = np.abs(AWAY_MM - 150) < 6
    for tone in (0.3, 0.5, 0.8):
        image = radiance(hang(Finish(screen_mm=3.0, tone=tone)))
        assert image[ring].mean() == pytest.approx(1 - tone, abs=0.06)
        assert image[np.abs(AWAY_MM - 125) < 8].min() > 0.99
    coarse, fine = (radiance(hang(Finish(screen_mm=pitch, tone=0.5)))[ring].std() for pitch in (9.0, 2.0))
    assert coarse > 2 * fine  # dots larger than a pixel are seen


def test_wear_takes_ink_and_no_paper():
    image = radiance(hang(Finish(wear=0.8, wear_mm=20.0)))
    ring = np.abs(AWAY_MM - 150) < 6
    assert 0.1 < image[ring].mean() < 0.7 and image[ring].min() < 0.05 and image[ring].max() > 0.6
    assert image[np.abs(AWAY_MM - 125) < 8].min() > 0.99


def test_what_is_torn_off_shows_the_ceiling():
    torn = Finish(torn=((0.0, 120.0),), jag_mm=4.0)
    image = radiance(hang(torn))
    up = (MIDDLE[0] - ROWS) * MM
    assert image[up > 145] == pytest.approx(0.6, abs=1e-5)
    whole = radiance(hang())
    assert np.array_equal(image[up < 95], whole[up < 95])
    border = [np.nonzero(np.abs(image[:, column] - 0.6) > 0.2)[0][0] for column in range(165, 195)]
    assert len(set(border)) > 2  # a tear is not straight


def test_a_sheet_is_square():
    image = radiance(hang(Finish(sheet=True)))
    assert image[147 - 95, 180 - 95] == image[147 + 95, 180 + 95] == 1.0
    assert radiance(hang())[147 - 95, 180 - 95] == pytest.approx(0.6)


def test_flicker_bands_have_half_the_mains_period_and_vanish_in_whole_periods():
    camera = replace(CAMERA, row_us=70.0, exposure_us=3000.0)
    for mains_hz in (50.0, 60.0):
        gain = Flicker(0.5, mains_hz, 0.3).gain(camera)[:, 0]
        assert gain.min() > 0.5 and gain.max() < 1.5
        crossings = np.nonzero(np.diff(np.sign(gain - 1)))[0]
        rows = np.diff(crossings[::2]).mean()
        assert rows * 70e-6 == pytest.approx(1 / (2 * mains_hz), rel=0.02)
        whole = Flicker(0.5, mains_hz).gain(replace(camera, exposure_us=1e6 / (2 * mains_hz)))
        assert np.abs(whole - 1).max() < 1e-6
    longer = Flicker(0.5).gain(replace(camera, exposure_us=7000.0))
    assert np.ptp(longer) < 0.5 * np.ptp(Flicker(0.5).gain(camera))


STEP = np.where(np.arange(64) < 32, 60.0, 180.0).astype(np.float32) * np.ones((48, 1), np.float32)


def test_sharpening_overshoots_on_both_sides_of_an_edge_and_keeps_flat_places():
    sharp = Processing(sharpen=1.0, sharpen_px=1.5).run(STEP)
    assert sharp[20].max() > 190 and sharp[20].min() < 50
    assert sharp[20, 5] == pytest.approx(60, abs=0.01) and sharp[20, 60] == pytest.approx(180, abs=0.01)
    assert sharp[20, 31] + sharp[20, 32] == pytest.approx(240, abs=0.01)  # the edge stays where it is


def test_tone_curves_rise_and_do_what_they_are_named_after():
    ramp = np.linspace(0, 255, 256, dtype=np.float32)[None]
    for tone in (Processing(gamma=2.2), Processing(curve=0.7), Processing(curve=-0.3, lift=20)):
        out = tone.run(ramp)[0]
        assert (np.diff(out) >= 0).all() and out[-1] == pytest.approx(255, abs=0.01)
    assert Processing(gamma=2.2).run(ramp)[0, 30] > 90  # shadows lifted
    curve = Processing(curve=0.7).run(ramp)[0]
    assert curve[60] < 60 and curve[195] > 195
    assert Processing(lift=20).run(ramp)[0, 0] == pytest.approx(20)
    assert np.array_equal(Processing().run(ramp), ramp)


def noisy(image, seed, sigma=6.0):
    return (image + generator("test", seed).normal(0, sigma, image.shape)).astype(np.float32)


def test_denoising_lowers_noise_and_keeps_edges():
    frame = noisy(STEP, 1)
    for processing in (Processing(median_px=3), Processing(median_px=5), Processing(bilateral=(2.0, 30.0))):
        out = processing.run(frame)
        assert out[:, 4:24].std() < 0.6 * frame[:, 4:24].std()
        assert out[:, 34].mean() - out[:, 29].mean() > 105
    dotted = STEP.copy()
    dotted[10, 10] = 255
    assert Processing(median_px=3).run(dotted)[10, 10] == 60


def test_temporal_denoising_averages_what_stands_and_leaves_what_moved():
    processing = Processing(temporal=0.5, temporal_grey=12)
    still = processing.run(noisy(STEP, 1), noisy(STEP, 2))
    assert still[:, 4:24].std() < 0.85 * 6
    moved = processing.run(STEP, np.roll(STEP, 8, axis=1))
    assert np.array_equal(moved[:, 33:39], STEP[:, 33:39])


def test_enlarged_frames_are_softer_and_shifted_by_nothing():
    scene = hang()
    sensor = Sensor(contrast=200, black=20)
    frames = [
        render_view(scene, Pose(), Motion(), CAMERA, replace(sensor, scale=scale), generator("test", 1))[0]
        for scale in (1.0, 0.5)
    ]
    plain, enlarged = (frame.astype(float) for frame in frames)
    assert enlarged.shape == plain.shape
    steep = [np.abs(np.diff(image, axis=1)).max() for image in (plain, enlarged)]
    assert steep[1] < 0.75 * steep[0]
    near = AWAY_MM < 240
    place = [
        [np.average(axis[near], weights=220 - image[near]) for axis in (ROWS, COLUMNS)]
        for image in (plain, enlarged)
    ]
    assert np.abs(np.subtract(*place)).max() < 0.02


def test_interlaced_rows_are_of_two_times_around_the_truth():
    motion, sensor = Motion(left_mm_s=250.0), Sensor(contrast=200, black=20)
    frame, (truth,) = render_view(
        hang(), Pose(), motion, CAMERA, replace(sensor, field_us=40000.0), generator("test", 1)
    )
    early, late = (
        render_view(hang(), motion.pose_after(Pose(), s), motion, CAMERA, sensor, generator("test", 1))
        for s in (-0.02, 0.02)
    )
    assert np.array_equal(frame[::2], early[0][::2]) and np.array_equal(frame[1::2], late[0][1::2])
    assert abs(early[1][0].x_px - late[1][0].x_px) == pytest.approx(4.0, abs=0.01)
    assert (early[1][0].x_px + late[1][0].x_px) / 2 == pytest.approx(truth.x_px, abs=1e-6)


def test_over_exposure_clips_the_plate_and_not_the_ink():
    frame, _ = render_view(
        hang(), Pose(), Motion(), CAMERA, Sensor(contrast=150, black=20, exposure=2.0), generator("test", 1)
    )
    assert (frame[np.abs(AWAY_MM - 125) < 8] == 255).all()
    assert frame[np.abs(AWAY_MM - 150) < 4].max() < 60


def test_defects_stay_where_they_are():
    flat = np.full((100, 120), 50.0, np.float32)
    defects = Defects(hot=0.01, dead=0.01, columns=2.0, stuck_columns=2, seed=4)
    first, second = (defects.apply(flat, generator("test", seed)) for seed in (1, 2))
    assert np.array_equal(first, second)
    hot, dead = first > 100, first == 0
    assert 60 < hot.sum() < 460 and 60 < dead.sum() < 180
    assert np.median(first, axis=0).std() > 1.3
    rows = [Defects(rows=2.0, seed=4).apply(flat, generator("test", seed)) for seed in (1, 2)]
    assert not np.array_equal(*rows) and rows[0].std(axis=0).mean() == pytest.approx(2.0, abs=0.5)
    assert rows[0].std(axis=1).max() < 1e-4
    assert np.array_equal(Defects().apply(flat, generator("test", 1)), flat)


def test_dirt_on_the_lens_blurs_dims_and_veils_one_place_and_not_another():
    stripes = np.where(np.arange(360) // 6 % 2, 1.0, 0.2).astype(np.float32) * np.ones((296, 1), np.float32)
    spot = Smear(x=0.25, y=0.5, long=0.2, wide=0.2, angle=0.0, blur=4.5, loss=0.0, veil=0.0)
    seen = look_through(stripes, (spot,))
    assert np.ptp(seen[148, 84:96]) < 0.3 * np.ptp(stripes[148])
    assert seen[148, 84:96].mean() == pytest.approx(0.6, abs=0.05)
    assert np.abs(seen[:, 250:] - stripes[:, 250:]).max() < 1e-4
    flat = np.ones((296, 360), np.float32)
    dim = look_through(flat, (replace(spot, blur=0.0, loss=0.4, veil=0.1),))
    assert dim[148, 90] == pytest.approx(0.7, abs=0.01) and dim[148, 300] == pytest.approx(1.0, abs=1e-4)


def test_an_uneven_blur_is_as_wide_as_asked():
    edge = np.where(np.arange(360) < 180, 0.0, 1.0).astype(np.float32) * np.ones((296, 1), np.float32)
    for blur in (0.8, 1.7, 3.5):
        everywhere = Smear(x=0.5, y=0.5, long=30, wide=30, angle=0, blur=blur * 300 / 296, loss=0, veil=0)
        spread = np.diff(look_through(edge, (everywhere,))[148])
        x = np.arange(359) - 179
        assert np.sqrt((spread * x * x).sum()) == pytest.approx(blur, rel=0.06)


NEW = ("glossy", "webcam", "dirty_lens", "worn")


@pytest.fixture(scope="module")
def drawn():
    return {preset: [draw_view(preset, 6, index) for index in range(80)] for preset in NEW}


def test_the_presets_draw_every_trouble(drawn):
    plates = {name: [view.scene.plates[0] for view in drawn[name]] for name in NEW}
    sensors = {name: [view.sensor for view in drawn[name]] for name in NEW}

    def share(things, has):
        return np.mean([bool(has(thing)) for thing in things])

    assert share(plates["glossy"], lambda plate: plate.finish.gloss) > 0.8
    assert share(drawn["glossy"], lambda view: view.scene.low_lamps) > 0.8
    for name, has in (
        ("glossy", lambda plate: plate.finish.curl_per_m),
        ("webcam", lambda plate: plate.black > 0.2),
        ("worn", lambda plate: plate.finish.screen_mm),
        ("worn", lambda plate: plate.finish.wear),
        ("worn", lambda plate: plate.finish.torn),
        ("worn", lambda plate: plate.black > 0.2 and plate.white < 0.95),
        ("glossy", lambda plate: plate.finish.sheet),
    ):
        assert 0.1 < share(plates[name], has) < 0.9
    for name, has in (
        ("webcam", lambda sensor: sensor.flicker.depth),
        ("webcam", lambda sensor: sensor.scale < 1),
        ("webcam", lambda sensor: sensor.defects.hot),
        ("webcam", lambda sensor: sensor.processing.gamma > 1),
        ("webcam", lambda sensor: sensor.processing.sharpen),
        ("webcam", lambda sensor: sensor.processing.temporal),
        ("webcam", lambda sensor: sensor.processing.median_px),
        ("webcam", lambda sensor: sensor.processing.bilateral[0]),
        ("webcam", lambda sensor: sensor.jpeg),
        ("glossy", lambda sensor: sensor.exposure > 1),
    ):
        assert 0.1 < share(sensors[name], has) < 0.95
    assert 0.02 < share(sensors["webcam"], lambda sensor: sensor.field_us) < 0.3
    assert share(sensors["dirty_lens"], lambda sensor: len(sensor.lens) >= 3) == 1
    cables = [row for view in drawn["worn"] for row in view.scene.occluders]
    values = np.array([row[painters.VALUE] for row in cables])
    assert (values < 0.4).sum() > 5 and (values > 0.9).sum() > 5
    edges = [row for view in drawn["webcam"] for row in view.scene.shades if row[painters.A] == 6000]
    assert len(edges) > 10 and min(row[painters.SOFT] for row in edges) < 10


def test_given_contrast_and_tags_hold_in_troubled_scenes_too():
    assert all(draw_view("worn", 6, index, contrast=50.0).scene.plates[0].black == 0 for index in range(12))
    marker, tag = (draw_view("worn", 6, 3, target=target) for target in ("larics", "apriltag"))
    assert marker.scene.plates[0].finish == tag.scene.plates[0].finish
    assert marker.scene.plates[0].black == tag.scene.plates[0].black and marker.sensor == tag.sensor


def test_a_drive_keeps_its_troubles_from_frame_to_frame():
    drive = draw_drive("glossy", 3, marker_ids=(3, 4), width=180, height=148, radius_px=15)
    assert drive.scene.low_lamps and any(plate.finish.gloss for plate in drive.scene.plates)
    smeared = draw_drive("dirty_lens", 3, marker_ids=(3, 4), width=180, height=148, radius_px=15)
    assert len(smeared.sensor.lens) >= 3
    assert np.array_equal(smeared.frame(7)[0], smeared.frame(7)[0])


def test_presets_without_troubles_are_drawn_and_developed_as_if_there_were_none():
    for preset in PRESETS:
        if preset not in NEW:
            view = draw_view(preset, 6, 0)
            assert view.sensor.plain and not view.scene.low_lamps
            assert all(plate.finish == Finish() for plate in view.scene.plates)
