"""The camera boards: how each is recognised, wired and built for. One table for firmware, PC and README.

None of these boards was at hand: every entry comes from the makers' documents and sources.
"""


class Board:
    """One board.

    name         at most 16 characters, as reported on the wire
    identities   each a text that omv.arch() or os.uname().machine contains on this board
    usb_ids      (vendor, product) of its USB port
    camera       module of its camera: "csi" or "esp32"
    uart         number or name of machine.UART, and the pins it comes out at
    tx, rx       those pins, as printed on the board; tx goes to the vehicle's RX
    uart_pins    pin numbers to give to machine.UART, None where the number alone decides
    button       name or number of the pin that a held button pulls low, None without a button
    leds         names for machine.LED: red, green, blue; None without
    flash        where the file system for programs is mounted
    arch         of mpy-cross -march
    readout_us   from the end of an exposure until the frame is complete, at 320x240: one over the sensor's
                 highest frame rate
    tier         1: first choice; 2: supported; 3: experimental
    """

    def __init__(self, name, identities, usb_ids, camera, uart, tx, rx, uart_pins, button, readout_us, tier,
    flash="/flash", arch="armv7emsp", leds=("LED_RED", "LED_GREEN", "LED_BLUE")):  # fmt: skip
        self.name = name
        self.identities = identities
        self.usb_ids = usb_ids
        self.camera = camera
        self.uart = uart
        self.tx = tx
        self.rx = rx
        self.uart_pins = uart_pins
        self.button = button
        self.readout_us = readout_us
        self.tier = tier
        self.flash = flash
        self.arch = arch
        self.leds = leds


_OPENMV = 0x37C5

BOARDS = (
    Board("OpenMV N6", ("OpenMV N6", "OPENMV_N6"), ((_OPENMV, 0x1206),), "csi", 3, "P4", "P5", None, "SW",
    2200, 1),
    Board("OpenMV RT1062", ("OMVRT1060", "OPENMV_RT1060"), ((_OPENMV, 0x1060),), "csi", 1, "P4", "P5", None,
    "SW", 12000, 1),
    Board("OpenMV AE3", ("OPENMV AE3", "OPENMV_AE3"), ((_OPENMV, 0x16E3),), "csi", 1, "P4", "P5", None, "SW",
    2200, 2),
    Board("OpenMV H7 Plus", ("OMV4P H7", "OPENMV4P"), ((_OPENMV, 0x124A),), "csi", 3, "P4", "P5", None, None,
    12000, 2),
    Board("Nicla Vision", ("NICLAV", "NICLA_VISION"), ((0x2341, 0x045F),), "csi", "LP1", "PA9", "PA10", None,
    None, 33000, 2),
    Board("ESP32-S3", ("ESP32S3", "ESP32-S3"), ((0x303A, 0x1001), (0x303A, 0x4001)), "esp32", 1, "GPIO43",
    "GPIO44", (43, 44), 0, 40000, 3, flash="/", arch="xtensawin", leds=None),
)  # fmt: skip


def find(identity):
    """The board whose identity text is contained in this one; None when there is none."""
    wanted = identity.lower()
    for board in BOARDS:
        for text in board.identities:
            if text.lower() in wanted:
                return board
    return None
