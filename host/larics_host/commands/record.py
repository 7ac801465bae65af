"""`larics record`: what a camera saw, as a folder of frames with its messages beside them."""

from __future__ import annotations

import argparse
import time

from larics_host.errors import UserError
from larics_host.wording import counted

NAME = "record"
HELP = "raw frames from a camera or an ImageIO stream, in a folder with the messages beside them"
EXAMPLE = """
larics record --port /dev/ttyACM0 --frames 20 -o seen
larics record --port /dev/ttyACM0 --window --frames 100 -o markers
larics record --input clip.bin --log run.jsonl -o seen
larics detect seen --draw drawn
"""

MESSAGES = "messages"
SETTINGS = "settings.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--port", metavar="DEVICE", help="serial port of the camera, or tcp://HOST:PORT")
    source.add_argument("--input", metavar="STREAM.bin", help="an OpenMV ImageIO stream, or a video")
    parser.add_argument("--baud", type=int, default=115200, help="speed of the port (default 115200)")
    parser.add_argument("--frames", metavar="N", type=int, help="how many (a port: 10; a stream: all)")
    parser.add_argument("--seconds", metavar="N", type=float, help="begin no frame after N seconds")
    parser.add_argument("--log", metavar="FILE.jsonl", help="the log of larics log that goes with a stream")
    parser.add_argument(
        "--window",
        action="store_true",
        help="of each frame only what is around its markers, several times faster; the rest of the picture"
        " repeats the border of that window (a frame without a marker comes whole)",
    )
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder for the frames")
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="replace the frames that DIR holds, and what lies beside them",
    )


def run(args: argparse.Namespace) -> int:
    if args.frames is not None and args.frames < 1:
        raise UserError("--frames %d: give a number above 0" % args.frames)
    if args.seconds is not None and not args.seconds > 0:
        raise UserError("--seconds %g: give a number above 0" % args.seconds)
    if args.log and args.port:
        raise UserError("--log goes with --input: the messages of a camera are recorded with its frames")
    if args.window and not args.port:
        raise UserError("--window goes with --port: the frames of a stream are there already")
    return _from_camera(args) if args.port else _from_stream(args)


def _from_stream(args):
    from larics_host.files import read_bytes, write_file
    from larics_host.images.frame_folder import frame_name, keeping, make_folder, write_frame
    from larics_host.images.frame_sources import open_frames
    from larics_host.logs.log_records import read_objects
    from larics_host.progress import watched

    frames = open_frames([args.input])
    first = next(frames)  # what cannot be read leaves no folder behind
    if args.log:
        next(read_objects(args.log), None)
    beside = [MESSAGES + ".jsonl"] if args.log else []
    folder = make_folder(args.output, args.overwrite, beside)
    with keeping(folder, beside) as kept:
        if args.log:
            write_file(folder / (MESSAGES + ".jsonl"), read_bytes(args.log))
        write_frame(folder / frame_name(0), first[1])
        kept.frames = 1
        for _, frame in watched(frames, args.frames, quiet_stdout=True):
            if args.frames and kept.frames >= args.frames:
                break
            write_frame(folder / frame_name(kept.frames), frame)
            kept.frames += 1
    print("%s in %s" % (counted(kept.frames, "frame"), folder))
    return 0


def _from_camera(args):
    from larics.wire.messages import MARKER
    from larics_host.connection.byte_sources import ConnectionLost, stop_on_signals
    from larics_host.connection.camera_settings import connected, read_all
    from larics_host.connection.camera_settings import write_file as write_settings
    from larics_host.connection.receiver import message_of
    from larics_host.images.frame_folder import frame_name, keeping, make_folder, write_frame
    from larics_host.logs.log_writer import LogWriter
    from larics_host.progress import measured

    start_s, start_ns = time.monotonic(), time.time_ns()
    recorder = None
    before, reported = [], []  # messages until there is a folder; the first frame that a message is about

    def on_message(number, sequence, values):
        message = message_of(number, sequence, values, time.monotonic() - start_s)
        if number == MARKER and not reported:
            reported.append(message.fields.frame)
        if recorder:
            recorder.write(message)
        else:
            before.append(message)

    wanted = args.frames or 10
    beside = SETTINGS, MESSAGES + ".csv", MESSAGES + ".jsonl"
    with connected(args.port, args.baud, on_message) as client:
        settings = read_all(client)
        folder = make_folder(args.output, args.overwrite, beside)
        with keeping(folder, beside) as kept:
            write_settings(folder / SETTINGS, settings)
            recorder = LogWriter(str(folder / MESSAGES), force=True, start_ns=start_ns)
            try:
                for message in before:
                    recorder.write(message)
                with measured(wanted) as progress, stop_on_signals(live=False):
                    while kept.frames < wanted:
                        if args.seconds is not None and time.monotonic() - start_s >= args.seconds:
                            break
                        done = kept.frames
                        raw = client.raw_frame(
                            lambda got, total, done=done: progress(done + got / total),
                            around_markers=args.window,
                        )
                        if reported and raw.frame < reported[0]:
                            continue  # its message was sent before anyone listened
                        write_frame(folder / frame_name(raw.frame), raw.array())
                        kept.frames += 1
            except KeyboardInterrupt:
                pass  # what was fetched so far is complete
            except ConnectionLost as error:
                raise UserError(str(error)) from None
            finally:
                recorder.close()
    print("%s, %s and %s.jsonl in %s" % (counted(kept.frames, "frame"), SETTINGS, MESSAGES, folder))
    return 0
