"""Messages as a bag of ROS 2, which Foxglove opens and `ros2 bag play` plays: topics of a robot, and beside
them every message of the camera as it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from larics_host.ros.bag import Bag
from larics_host.ros.view import View

if TYPE_CHECKING:
    import numpy as np

    from larics_host.annotations import StrPath
    from larics_host.connection.receiver import Message
    from larics_host.ros.options import Options


class McapLog:
    """PATH.mcap, or with folder=True a folder as rosbag2 makes it; see ros.bag and ros.view.

    start_ns: wall clock of the messages' time_s 0.
    """

    def __init__(
        self, path: StrPath, start_ns: int, options: Options | None = None, folder: bool = False
    ) -> None:
        self._bag = Bag(path, folder)
        self._view = View(options)
        self._start_ns = start_ns
        self._last_ns = start_ns

    def write(self, message: Message) -> None:
        """Adds a receiver.Message and what follows from it."""
        received_ns = self._start_ns + 1000 * round(message.time_s * 1e6)  # as the JSON lines have it
        self._last_ns = max(self._last_ns, received_ns)
        for output in self._view.messages(message, received_ns):
            self._bag.write(output, self._last_ns, message.sequence)

    def picture(self, number: int, frame: np.ndarray) -> None:
        """Adds a raw frame ((height, width) uint8) of which a message was written, by its number."""
        for output in self._view.picture(number, frame):
            self._bag.write(output, self._last_ns)

    def close(self) -> None:
        """Ends the file. CannotWrite when there is no room for its end."""
        try:
            for output in self._view.finish():
                self._bag.write(output, self._last_ns)
        finally:
            self._bag.close()

    def discard(self) -> None:
        """Removes the file."""
        self._bag.discard()
