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
    heap_kib     memory for MicroPython objects, the frame buffers of an OpenMV board not counted
    readout_us   from the end of an exposure until the frame is complete, at 320x240: one over the sensor's
                 highest frame rate
    tier         1: first choice; 2: supported; 3: experimental
    """

    def __init__(
        self, name, identities, usb_ids, camera, uart, tx, rx, button, heap_kib, readout_us, tier,
        uart_pins=None, flash="/flash", arch="armv7emsp", leds=("LED_RED", "LED_GREEN", "LED_BLUE"),
    ):  # fmt: skip
        self.name = name
        self.identities = identities
        self.usb_ids = usb_ids
        self.camera = camera
        self.uart = uart
        self.tx = tx
        self.rx = rx
        self.uart_pins = uart_pins
        self.button = button
        self.heap_kib = heap_kib
        self.readout_us = readout_us
        self.tier = tier
        self.flash = flash
        self.arch = arch
        self.leds = leds


_OPENMV = 0x37C5

BOARDS = (
    Board(
        "OpenMV N6", ("OpenMV N6", "OPENMV_N6"), ((_OPENMV, 0x1206),), "csi", 3, "P4", "P5",
        button="SW", heap_kib=25600, readout_us=2200, tier=1,
    ),
    Board(
        "OpenMV RT1062", ("OMVRT1060", "OPENMV_RT1060"), ((_OPENMV, 0x1060),), "csi", 1, "P4", "P5",
        button="SW", heap_kib=8460, readout_us=12000, tier=1,
    ),
    Board(
        "OpenMV AE3", ("OPENMV AE3", "OPENMV_AE3"), ((_OPENMV, 0x16E3),), "csi", 1, "P4", "P5",
        button="SW", heap_kib=4096, readout_us=2200, tier=2,
    ),
    Board(
        "OpenMV H7 Plus", ("OMV4P H7", "OPENMV4P"), ((_OPENMV, 0x124A),), "csi", 3, "P4", "P5",
        button=None, heap_kib=4328, readout_us=12000, tier=2,
    ),
    Board(
        "Nicla Vision", ("NICLAV", "NICLA_VISION"), ((0x2341, 0x045F),), "csi", "LP1", "PA9", "PA10",
        button=None, heap_kib=369, readout_us=33000, tier=2,
    ),
    Board(
        "ESP32-S3", ("ESP32S3", "ESP32-S3"), ((0x303A, 0x1001), (0x303A, 0x4001)), "esp32", 1, "GPIO43",
        "GPIO44", button=0, heap_kib=2048, readout_us=40000, tier=3, uart_pins=(43, 44), flash="/",
        arch="xtensawin", leds=None,
    ),
)  # fmt: skip


def find(identity):
    """The board whose identity text is contained in this one; None when there is none."""
    wanted = identity.lower()
    for board in BOARDS:
        for text in board.identities:
            if text.lower() in wanted:
                return board
    return None
