"""A webcam on the network for tests: multipart JPEG over HTTP on loopback."""

import contextlib
import http.server
import itertools
import struct
import threading

import cv2

from tests.host.test_dual import ROOT

NAMES = ["sunny_r30_1000_%d.pgm" % k for k in range(3)]
PICTURES = [cv2.imread(str(ROOT / "tests/frames" / name), cv2.IMREAD_GRAYSCALE) for name in NAMES]


def jpeg(frame):
    return cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()


class Stream(http.server.BaseHTTPRequestHandler):
    """Multipart JPEG, as webcams and OpenMV's own examples serve it; `server.body` makes the pictures."""

    def do_GET(self):
        server = self.server
        server.opened += 1
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        self.end_headers()
        for number in itertools.count():
            body = server.body(number)
            while body is None and not server.stop.wait(0.02):  # silent, with the connection open
                body = server.body(number)
            if server.stop.wait(0.01):
                return
            head = b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(body)
            self.wfile.write(head + body + b"\r\n")

    def log_message(self, *_):
        pass

    def handle(self):
        with contextlib.suppress(OSError):
            super().handle()


@contextlib.contextmanager
def mjpeg_server(body=None, port=0):
    """`body(number)`: the next picture of a connection, None for silence."""
    bodies = [jpeg(frame) for frame in PICTURES]
    server = http.server.ThreadingHTTPServer(("127.0.0.1", port), Stream)
    server.body = body or (lambda number: bodies[number % 3])
    server.stop = threading.Event()
    server.opened = 0
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    server.address = "http://127.0.0.1:%d/" % server.server_address[1]
    try:
        yield server
    finally:
        server.stop.set()
        server.shutdown()
        server.server_close()


def tag_turn(path, turn):
    """Writes into an MP4 of one track that it is to be shown turned by `turn` degrees clockwise."""
    data = bytearray(path.read_bytes())
    place = data.index(b"tkhd") + 44  # the matrix of the track
    cosine, sine = {0: (1, 0), 90: (0, 1), 180: (-1, 0), 270: (0, -1)}[turn]
    matrix = [cosine << 16, sine << 16, 0, -sine << 16, cosine << 16, 0, 0, 0, 1 << 30]
    data[place : place + 36] = struct.pack(">9i", *matrix)
    path.write_bytes(data)
