"""The presets: what kinds of ceilings, light and driving there are."""

from dataclasses import dataclass, replace

from larics_host.render.troubles import Troubles


@dataclass(frozen=True)
class Preset:
    """Ranges (low, high) that a frame is drawn from; shares are probabilities, counts inclusive.

    contrast, black, read_noise, shot_noise, vignetting, defocus_px   see Sensor
    exposure_us, speed_mm_s, turn_deg_s, tilt_deg
    markers        how many; place: "inside", or "border" to be cut off by the frame
    circles, straight, decoys   pieces of furniture in a view of two square metres
    lamp_share     that there are lamps, `lamp_grey` how bright; share of frames with glare (a bright patch
                   on the plate), a shadow anywhere, the edge of one on the plate, dirt, something in the way
    jpeg_share     that the frame went through JPEG of a quality of 60 to 95
    row_us         rolling shutter, time from row to row: instead of the series' own
    troubles       what else happens to print, light, lens and picture
    """

    summary: str
    contrast: tuple = (90.0, 170.0)
    black: tuple = (15.0, 50.0)
    read_noise: tuple = (0.6, 1.2)
    shot_noise: tuple = (0.004, 0.012)
    vignetting: tuple = (0.05, 0.35)
    defocus_px: tuple = (0.3, 0.8)
    exposure_us: tuple = (3000.0, 9000.0)
    speed_mm_s: tuple = (150.0, 220.0)
    turn_deg_s: tuple = (-8.0, 8.0)
    tilt_deg: tuple = (0.0, 2.0)
    markers: tuple = (1, 1)
    place: str = "inside"
    circles: tuple = (0, 2)
    straight: tuple = (0, 2)
    decoys: tuple = (0, 0)
    lamp_share: float = 0.3
    lamp_grey: tuple = (200.0, 600.0)
    glare: float = 0.0
    shadow: float = 0.3
    edge: float = 0.0
    dirt: float = 0.1
    block: float = 0.0
    jpeg_share: float = 0.3
    row_us: tuple | None = None
    troubles: Troubles | None = None


SUNNY = Preset("daylight: high contrast, short exposure, 20 cm/s")
CLOUDY = replace(
    SUNNY,
    summary="dim light: 20-40 grey levels of contrast, 33-60 ms exposure, 20 cm/s",
    contrast=(20.0, 40.0),
    black=(15.0, 45.0),
    read_noise=(1.0, 1.6),
    shot_noise=(0.015, 0.04),
    exposure_us=(33000.0, 60000.0),
    lamp_share=0.1,
)
PRESETS = {
    "sunny": SUNNY,
    "cloudy": CLOUDY,
    "double": replace(SUNNY, summary="daylight at 40 cm/s", speed_mm_s=(380.0, 420.0)),
    "fast": replace(
        SUNNY,
        summary="150 cm/s with 2-4 ms exposure",
        contrast=(60.0, 130.0),
        read_noise=(0.9, 1.5),
        shot_noise=(0.008, 0.02),
        exposure_us=(2000.0, 4000.0),
        speed_mm_s=(1400.0, 1600.0),
        turn_deg_s=(-20.0, 20.0),
    ),
    "harsh": replace(
        SUNNY,
        summary="lamps on the marker, 3-10 degrees of tilt, shadows, things in the way, dirt, low light",
        contrast=(35.0, 110.0),
        black=(10.0, 50.0),
        read_noise=(1.0, 2.0),
        shot_noise=(0.01, 0.035),
        vignetting=(0.1, 0.5),
        defocus_px=(0.4, 1.1),
        exposure_us=(5000.0, 25000.0),
        tilt_deg=(3.0, 10.0),
        circles=(0, 3),
        straight=(0, 3),
        lamp_share=0.5,
        glare=0.5,
        shadow=0.7,
        edge=0.5,
        dirt=0.7,
        block=0.35,
        jpeg_share=0.5,
    ),
    "multi": replace(SUNNY, summary="two to four markers", markers=(2, 4)),
    "border": replace(SUNNY, summary="the marker is cut off by the border of the frame", place="border"),
    "negative": replace(
        SUNNY,
        summary="cluttered ceilings without a marker, decoys included",
        contrast=(20.0, 170.0),
        read_noise=(0.6, 2.0),
        shot_noise=(0.004, 0.035),
        exposure_us=(2000.0, 30000.0),
        tilt_deg=(0.0, 6.0),
        markers=(0, 0),
        circles=(1, 6),
        straight=(0, 5),
        decoys=(0, 2),
        lamp_share=0.5,
        shadow=0.5,
    ),
    "glossy": replace(
        SUNNY,
        summary="glossy and curled plates that mirror lamps, edges of light, tone curves",
        contrast=(50.0, 150.0),
        tilt_deg=(0.0, 4.0),
        troubles=Troubles(
            sheet=0.5, curl=0.5, gloss=0.9, lit_edge=0.3, over=0.15, tone=0.5, sharpen=0.3, bilateral=0.2
        ),
    ),
    "webcam": replace(
        SUNNY,
        summary="a webcam: denoised, sharpened, enlarged, tone curves, flicker bands, JPEG; faint prints",
        contrast=(30.0, 130.0),
        black=(5.0, 40.0),
        read_noise=(1.0, 3.0),
        shot_noise=(0.01, 0.05),
        exposure_us=(4000.0, 15000.0),
        jpeg_share=0.7,
        row_us=(40.0, 100.0),
        troubles=Troubles(
            sheet=0.6,
            faint=0.35,
            lit_edge=0.35,
            over=0.1,
            flicker=0.4,
            interlaced=0.1,
            upscaled=0.3,
            defects=0.2,
            tone=0.8,
            sharpen=0.6,
            temporal=0.3,
            median=0.25,
            bilateral=0.35,
        ),  # fmt: skip
    ),
    "dirty_lens": replace(
        SUNNY,
        summary="finger marks and dust on the lens: parts of the picture blurred, dimmed and veiled",
        contrast=(40.0, 150.0),
        troubles=Troubles(sheet=0.3, smears=(3, 8), tone=0.3, defects=0.1),
    ),
    "worn": replace(
        SUNNY,
        summary="faint, grey, screened, rubbed, stained and torn prints, cables across them",
        contrast=(40.0, 150.0),
        black=(10.0, 50.0),
        tilt_deg=(0.0, 4.0),
        troubles=Troubles(
            sheet=0.5,
            curl=0.3,
            faint=0.4,
            screen=0.25,
            wear=0.3,
            torn=0.25,
            stains=0.4,
            cable=0.3,
            lit_edge=0.2,
            tone=0.2,
        ),
    ),
}
