"""Lines to the vehicle for a computer: a serial port, a pseudo-terminal, TCP on loopback, standard output.

Each has the calls of machine.UART that serial_line.SerialLine makes: any(), readinto(buffer, count) and
write(buffer, offset, count), none of which waits; write returns how many bytes were taken, None for none.
"""

import errno
import fcntl
import os
import select
import socket
import sys
import termios
import tty

MEMORY_BAUD = 10000000  # bits a second of a line that is none: memory to memory


class Closed(BaseException):
    """Whoever read standard output is gone: there is nobody to work for. Not an error of the line."""


class _Descriptor:
    """A line on a file descriptor that does not block. baud: bits a second that it takes, or None."""

    baud = None

    def __init__(self, reading, writing):
        self._reading = reading
        self._writing = writing

    def any(self):
        return 64 if self._reading is not None and select.select([self._reading], [], [], 0)[0] else 0

    def readinto(self, buffer, count):
        try:
            data = os.read(self._reading, count)
        except BlockingIOError:
            return None
        buffer[: len(data)] = data
        return len(data)

    def write(self, buffer, offset, count):
        try:
            return os.write(self._writing, memoryview(buffer)[offset : offset + count])
        except BlockingIOError:
            return None

    def close(self):
        pass


class StandardOutput(_Descriptor):
    """The stream on standard output; nothing is received. Raises Closed when its reader has gone."""

    name = "standard output"
    baud = MEMORY_BAUD

    def __init__(self):
        super().__init__(None, sys.stdout.fileno())

    def write(self, buffer, offset, count):
        try:
            return super().write(buffer, offset, count)
        except BrokenPipeError:
            raise Closed from None


class PseudoTerminal(_Descriptor):
    """A pseudo-terminal; `name` is the device for the other side, also as the symbolic link `link`.

    While nobody has it open, what is written is thrown away, as on a cable without a listener."""

    def __init__(self, link=None):
        master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        self._slave = slave  # kept open, so that the line survives whoever opens and closes it
        self.name = os.ttyname(slave)
        self._link = link
        if link:
            if os.path.islink(link):
                os.unlink(link)
            os.symlink(self.name, link)
        super().__init__(master, master)

    def write(self, buffer, offset, count):
        taken = super().write(buffer, offset, count)
        if taken is None:  # nobody reads: the oldest goes, a line does not wait either
            termios.tcflush(self._slave, termios.TCIFLUSH)
            taken = super().write(buffer, offset, count)
        return taken

    def close(self):
        if self._link and os.path.islink(self._link) and os.readlink(self._link) == self.name:
            os.unlink(self._link)


class SerialPort:
    """A serial port, for this program alone; opened again when it vanished and returned."""

    def __init__(self, device, baud):
        import serial

        self._error = serial.SerialException
        self.name, self.baud = device, baud
        self._port = serial.Serial(baudrate=baud, timeout=0, write_timeout=0, exclusive=True)
        self._port.port = device
        try:
            self._port.open()
        except self._error as error:
            if error.errno == errno.EAGAIN:
                why = "another program uses it"
            else:
                why = os.strerror(error.errno).lower() if error.errno else str(error)
            raise OSError("%s cannot be opened: %s" % (device, why))

    def _again(self):
        """Opens the port if it is there; OSError (what SerialException is) when not."""
        if not self._port.is_open:
            self._port.open()

    def any(self):
        try:
            self._again()
            return self._port.in_waiting
        except OSError:
            self._port.close()
            raise

    def readinto(self, buffer, count):
        data = self._port.read(count)
        buffer[: len(data)] = data
        return len(data)

    def write(self, buffer, offset, count):
        try:
            self._again()
            return self._port.write(memoryview(buffer)[offset : offset + count])
        except OSError as error:
            if "timeout" in str(error).lower():
                return None
            self._port.close()
            raise

    def close(self):
        self._port.close()


class TcpServer:
    """TCP on the loopback address, for one listener at a time; a newer one takes over."""

    baud = MEMORY_BAUD

    def __init__(self, port):
        try:
            self._server = socket.create_server(("127.0.0.1", port))
        except OSError as error:
            why = os.strerror(error.errno).lower()
            raise OSError("TCP port %d of this computer cannot be served: %s" % (port, why))
        self._server.setblocking(False)
        self.name = "127.0.0.1:%d" % self._server.getsockname()[1]
        self._peer = None

    def _accept(self):
        try:
            peer, _ = self._server.accept()
        except BlockingIOError:
            return
        self._drop()
        peer.setblocking(False)
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._peer = peer

    def _drop(self):
        if self._peer is not None:
            self._peer.close()
            self._peer = None

    def any(self):
        self._accept()
        return 64 if self._peer is not None and select.select([self._peer], [], [], 0)[0] else 0

    def readinto(self, buffer, count):
        try:
            data = self._peer.recv(count)
        except BlockingIOError:
            return None
        except OSError:
            data = b""
        if not data:
            self._drop()
            return 0
        buffer[: len(data)] = data
        return len(data)

    def write(self, buffer, offset, count):
        if self._peer is None:
            return count  # nobody listens
        try:
            return self._peer.send(memoryview(buffer)[offset : offset + count])
        except BlockingIOError:
            return None
        except OSError:
            self._drop()
            return count

    def close(self):
        self._drop()
        self._server.close()


def lock_of(path):
    """An open file with an exclusive lock, so that two cameras never share settings; OSError when taken."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return descriptor
