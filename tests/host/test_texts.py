"""Tables, settings and logs as other programs save them, and as crashes leave them."""

import json
import random

import pytest

from larics.wire import messages as m
from larics_host import cli, files
from larics_host.connection.receiver import Receiver
from larics_host.connection.records import Marker, known
from larics_host.errors import UserError, begin_run
from larics_host.logs.columns import read_columns
from larics_host.logs.log_reader import read_pieces
from larics_host.logs.log_records import read_objects
from larics_host.mapping.mapfile import read_csv
from larics_host.truth import COLUMNS, read_truth
from larics_host.validation.sources import read_log
from tests.host.test_replay import messages

ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1252")
SETTINGS = {"version": 1, "ceiling_mm10": 25000, "radius_min_px": 20}


@pytest.fixture
def log(tmp_path, capsys):
    """PREFIX of a log with all files."""
    (tmp_path / "came.bin").write_bytes(messages())
    prefix = tmp_path / "run"
    assert cli.main(["log", "--input", str(tmp_path / "came.bin"), "-o", str(prefix), "--mcap", "--raw"]) == 0
    capsys.readouterr()
    return prefix


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_texts_are_read_in_every_encoding(tmp_path, encoding, end):
    path = tmp_path / "file"
    text = json.dumps(SETTINGS, indent=1).replace("\n", end)
    path.write_bytes(text.encode(encoding))
    assert files.read_json(path) == SETTINGS
    path.write_bytes(("id,x_mm,y_mm,heading_deg" + end + "3,1.5,-2,90" + end).encode(encoding))
    (marker,) = read_csv(path)
    assert (marker.id, marker.x_mm, marker.y_mm, marker.heading_deg) == (3, 1.5, -2, 90)
    line = json.dumps({"frame": "Büro.pgm", "detections": []}, ensure_ascii=False)
    path.write_bytes((line + end).encode(encoding))
    assert list(read_log(path).by_frame) == ["Büro.pgm"]
    path.write_bytes((",".join(COLUMNS) + end + "Büro.pgm" + 15 * "," + end).encode(encoding))
    assert read_truth(path)[0].frame == "Büro.pgm"


@pytest.mark.parametrize(
    "text",
    [
        "id;x_mm;y_mm;heading_deg\n3;1500,5;-2;90\n",
        "id;x_mm;y_mm;heading_deg\n3;1500.5;-2.0;90\n",
        "id\tx_mm\ty_mm\theading_deg\n3\t1500,5\t-2,0\t90\n",
        "id|x_mm|y_mm|heading_deg\n3|1500.5|-2|90\n",
        "ID, X_mm ,y_mm,  heading_deg\n 3 , 1500.5, -2 ,90\n",
        '"id","x mm","y mm","Heading deg"\n"3","1500.5","-2","90"\n',
        "sep=;\nid;x_mm;y_mm;heading_deg\n3;1500,5;-2;90\n",
        "\n\nid;x_mm;y_mm;heading_deg;height_mm;radius_mm\n;;;;;\n3;1500,5;-2;90;;\n;;;;;\n\n",
        "id;x_mm;y_mm;heading_deg;;\n3;1500,5;-2;90;;\n",
        "heading_deg,id,y_mm,x_mm,height_mm\n90,3,-2,1500.5\n",  # Excel leaves empty cells out
        "id,x_mm,y_mm,heading_deg\r3,1500.5,-2,90\r",
        "id,x_mm,y_mm,heading_deg\n3,1500.5,-2,90",
    ],
)
def test_tables_of_all_spreadsheets_are_read(tmp_path, text):
    (tmp_path / "survey.csv").write_bytes(text.encode())
    (marker,) = read_csv(tmp_path / "survey.csv")
    assert (marker.id, marker.x_mm, marker.y_mm, marker.heading_deg) == (3, 1500.5, -2, 90)


@pytest.mark.parametrize(
    "data, part",
    [
        (b"", "is empty"),
        (b"\n\n", "there is no line that names the columns"),
        (b"id,x_mm,y_mm,heading_deg\n-3,0,0,0\n", "line 2: id is -3: 0 to 65534 are allowed"),
        (b"id,x_mm,y_mm,heading_deg\n3,0,2e7,0\n", "y_mm is 2e+07: -10000000 to 10000000 are allowed"),
        (b"id,x_mm,y_mm,heading_deg,sigma_mm\n3,0,0,0,-1\n", "sigma_mm is -1: 0 to 1000 are allowed"),
        (b"3,0,0,0\n", "its first line has to name the columns id,x_mm,y_mm,heading_deg"),
        (b"id,x_mm,y_mm\n3,0,0\n", "column heading_deg is missing"),
        (b"id,x_mm,x_mm,y_mm,heading_deg\n", "has the column x_mm twice"),
        (
            b"id;x_mm;y_mm;heading_deg\n3;1500,5;1.500;0\n",
            "1.500, but other numbers have the decimal",
        ),
        (b"id,x_mm,y_mm,heading_deg\n3,1,5,0,90\n", "line 2: 5 cells under a header of 4"),
        (b"id,x_mm,y_mm,heading_deg\n3,0,0,0\n5,15", "line 3: it ends after 2 of 4 cells, as if cut off"),
        (b"id,x_mm,y_mm,heading_deg\n3,0,0\n", "line 2: heading_deg is missing"),
        (b'id,x_mm,y_mm,heading_deg\n3,"1,500",0,0\n', "x_mm is '1,500', not a number"),
        (b"id,x_mm,y_mm,heading_deg\n3,0,0,0\n\0\0\0\0", "holds zero bytes: it was damaged"),
        (bytes(500), "holds nothing but zero bytes"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "is no text"),
        (b"\xff\xfei\0d", "is no text, or a damaged one: some of it is not UTF-16"),
    ],
)
def test_a_table_that_cannot_be_read_has_its_cause_named(tmp_path, data, part):
    (tmp_path / "survey.csv").write_bytes(data)
    with pytest.raises(UserError) as caught:
        read_csv(tmp_path / "survey.csv")
    assert part in str(caught.value) and "survey.csv" in str(caught.value)


@pytest.mark.parametrize(
    "data, part",
    [
        (b"", "it is empty"),
        (b'{"a": [1, 2', "it ends in the middle, as if cut off"),
        (b'{"a": 1}\n{"b": 2}', "Extra data in line 2"),
        (b"{a: 1}", "in line 1"),
        (b'{\n"a": 1, "b": 2,\n}', "nothing follows the comma in line 3"),
        (b"[1,\n]", "nothing follows the comma in line 2"),
        (b'{// height\n"a": 1}', "JSON has no comments: take out that in line 1"),
        (b'{"a": 1 /* mm */}', "JSON has no comments"),
        (b'# mine\n{"a": 1}', "JSON has no comments"),
        (b"{'a': 1}", 'straight double quotes, "", not in \' in line 1'),
        ("{\u201ca\u201d: 1}".encode(), "straight double quotes"),
        (b'{"a": 1, "ce', "it ends in the middle, as if cut off"),
        (b'{"a": ' + b"9" * 5000 + b"}", "a number in it has thousands of digits"),
        (b'{"a": 1, "b": [{"c": 2, "d": 3, "c": 4}]}', "gives c twice: take one of them out"),
        (b"[" * 40 + b"]" * 40, "it is nested more than 32 levels deep"),
        (b"[" * 100000, "it is nested more than 32 levels deep"),
        (b'{"a": 1}' + bytes(40), "holds zero bytes"),
    ],
)
def test_json_that_is_none_has_its_cause_named(tmp_path, data, part):
    (tmp_path / "a.json").write_bytes(data)
    with pytest.raises(UserError, match="a.json .*" + part):
        files.read_json(tmp_path / "a.json")


@pytest.mark.parametrize("depth", [33, 900, 100000])
@pytest.mark.parametrize(
    "command",
    [
        "settings check {json}",
        "settings restore --port none {json}",
        "settings set --port none route={text}",
        "map check {json}",
        "map draw {json} -o out.png",
        "map create out.json --settings {json}",
        "map build {jsonl} -o out.json",
        "calibrate --places {json} --settings {json}",
        "validate . --detections {jsonl}",
        "replay {jsonl} --stdout",
        "replay {mcap} --stdout",
        "monitor --input {jsonl}",
        "monitor --input {jsonl} --map {json}",
        "record --input {json} --log {jsonl} -o out",
    ],
)
def test_deep_nesting_is_one_line_everywhere(log, tmp_path, monkeypatch, capsys, command, depth):
    from mcap.writer import Writer

    monkeypatch.chdir(tmp_path)
    deep = "[" * depth + "]" * depth
    (tmp_path / "truth.csv").write_text(",".join(COLUMNS) + "\nf.pgm" + 15 * "," + "\n")
    (tmp_path / "deep.json").write_text('{"map": %s, "version": 1}' % deep)
    (tmp_path / "deep.jsonl").write_text('{"message": "INFO", "sequence": 1, "time_s": 1, "a": %s}\n' % deep)
    with open(tmp_path / "deep.mcap", "wb") as file:
        writer = Writer(file)
        writer.start("", "")
        schema = writer.register_schema("larics.INFO", "jsonschema", b"")
        channel = writer.register_channel("/a", "json", schema)
        writer.add_message(channel, 0, deep.encode(), 0, 0)
        writer.finish()
    words = command.format(json="deep.json", jsonl="deep.jsonl", mcap="deep.mcap", text=deep).split()
    assert cli.main(words) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and err.count("\n") == 1 and len(err) < 100000


def test_an_empty_cell_is_unknown(log):
    path = log.with_suffix(".csv")
    header, row, *_ = path.read_text().splitlines()
    cells = dict(zip(header.split(","), row.split(","), strict=True))
    path.write_text(header + "\n" + ",".join((cells | {"id": ""}).values()) + "\n")
    (piece,) = read_pieces(path)
    path.write_text(header + "\n" + ",".join((cells | {"id": str(m.ID_NONE)}).values()) + "\n")
    assert list(read_pieces(path)) == [piece]


def test_a_log_from_a_spreadsheet_is_read(log):
    path = log.with_suffix(".csv")
    pieces = list(read_pieces(path))
    rows = [line.split(",") for line in path.read_text().splitlines()]
    rows[0][0] = " Time_s"
    text = "".join(";".join(["note", row[0].replace(".", ","), *row[1:]]) + "\r\n" for row in rows)
    path.write_bytes(text.encode("utf-16"))
    assert list(read_pieces(path)) == pieces


def test_whole_numbers_are_read_as_pandas_writes_them(log, tmp_path):
    path = log.with_suffix(".csv")
    pieces = list(read_pieces(path))
    rows = [line.split(",") for line in path.read_text().splitlines()]
    floats = [[row[0], *(cell and cell + ".0" for cell in row[1:])] for row in rows[1:]]
    path.write_text("".join(",".join(row) + "\n" for row in [rows[0], *floats]))
    assert list(read_pieces(path)) == pieces
    truth = dict.fromkeys(COLUMNS, "") | {"frame": "a.pgm", "time_us": "1000.0", "id": "3.0"}
    (tmp_path / "truth.csv").write_text("%s\n%s\n" % (",".join(truth), ",".join(truth.values())))
    (one,) = read_truth(tmp_path)
    assert (one.id, one.time_us) == (3, 1000)
    (tmp_path / "truth.csv").write_text(
        "%s\n%s\n" % (",".join(truth), ",".join((truth | {"id": "3.5"}).values()))
    )
    with pytest.raises(UserError, match="line 2: a cell is not a number"):
        read_truth(tmp_path)


@pytest.mark.parametrize("number", ["1" + 400 * "0", "1e999", "NaN", "true", '"7"', "[7]", "7.5"])
@pytest.mark.parametrize("key", ["time_s", "sequence", "frame"])
def test_numbers_that_no_log_can_hold_cost_their_line_alone(log, tmp_path, capsys, key, number):
    path = log.with_suffix(".jsonl")
    whole = list(read_pieces(path))
    lines = path.read_text().splitlines()
    record = json.loads(lines[5])
    assert record["message"] == "MARKER"
    marked = json.dumps({**record, key: "here"})
    path.write_text("\n".join([*lines[:5], marked.replace('"here"', number), *lines[6:], ""]))
    is_time = key == "time_s" and number in ("true", "7.5")
    left = whole if is_time else whole[:5] + whole[6:]
    assert [piece.data for piece in read_pieces(path)] == [piece.data for piece in left]
    assert capsys.readouterr().err.count("\n") == (not is_time)
    # the readers of many logs and of long ones
    columns = read_columns(path, ["MARKER"])["MARKER"]
    received = Receiver().feed(b"".join(piece.data for piece in left), 0.0)
    assert len(columns) == sum(message.name == "MARKER" for message in received)
    assert cli.main(["fleet", str(path), "-o", str(tmp_path / "tables")]) == 0
    assert cli.main(["monitor", "--input", str(path), "--speed", "1000"]) == 0


def test_a_log_with_nothing_but_a_line_cut_off_is_told_as_such(log, capsys):
    path = log.with_suffix(".csv")
    header, row, *_ = path.read_text().splitlines(keepends=True)
    path.write_text(header + row[:20])
    assert cli.main(["replay", str(path), "--stdout", "--fast"]) == 2
    assert capsys.readouterr().err == "larics: %s line 2 is cut off\n" % path
    path.write_text("")
    assert cli.main(["replay", str(path), "--stdout", "--fast"]) == 2
    assert capsys.readouterr().err == "larics: %s is empty\n" % path


def test_damage_is_told_once_however_often_a_log_is_read(log, tmp_path, capsys):
    path = log.with_suffix(".jsonl")
    path.write_text(path.read_text()[:-20])
    assert cli.main(["log", "--convert", str(path), "-o", str(tmp_path / "again")]) == 0
    assert capsys.readouterr().err.count("is cut off; the rest is read") == 1


def spoiled(data, how, place):
    """The bytes of a log as a crash leaves them."""
    if how == "cut":
        return data[:place]
    if how == "zeros":
        return data[:place] + bytes(min(200, len(data) - place)) + data[place + 200 :]
    if how == "zeros at the end":
        return data[:place] + bytes(len(data) - place)
    return data[:place] + b"\xff\xfe\x80garbage\x91" + data[place:]


@pytest.mark.parametrize("how", ["cut", "zeros", "zeros at the end", "garbage"])
@pytest.mark.parametrize("suffix", [".csv", ".jsonl"])
def test_a_damaged_log_is_read_around_its_damage(log, capsys, suffix, how):
    path = log.with_suffix(suffix)
    data = path.read_bytes()
    whole = list(read_pieces(path))
    assert capsys.readouterr().err == ""
    header = data.index(b"\n") + 1 if suffix == ".csv" else 0
    first = data.index(b"\n", header) + 1
    draw = random.Random(1)
    for place in [first + 1, len(data) - 1] + [draw.randrange(first, len(data)) for _ in range(40)]:
        begin_run()
        path.write_bytes(spoiled(data, how, place))
        read = list(read_pieces(path))
        err = capsys.readouterr().err
        # nothing but what was received, in its order
        rest = iter(whole)
        assert read and all(piece in rest for piece in read)
        lost = data[place - 1 : place] != b"\n" or how != "cut"
        if lost and not (suffix == ".jsonl" and how == "cut" and place == len(data) - 1):
            assert len(read) < len(whole)
            assert err.count("\n") == 1 and "%s is damaged: line " % path.name in err
        if how in ("zeros", "garbage"):
            assert len(whole) - len(read) <= 5


def test_a_damaged_mcap_is_read_up_to_its_damage(tmp_path, capsys):
    (tmp_path / "came.bin").write_bytes(messages(600))
    path = tmp_path / "run.mcap"
    words = ["log", "--input", str(tmp_path / "came.bin"), "-o", str(tmp_path / "run"), "--mcap"]
    assert cli.main(words) == 0
    capsys.readouterr()
    data = path.read_bytes()
    whole = list(read_pieces(path))
    chunks = [place for place in range(len(data)) if data[place : place + 4] == b"\x28\xb5\x2f\xfd"]  # zstd
    place = chunks[2] + 20
    for how in ("cut", "zeros at the end"):
        path.write_bytes(spoiled(data, how, place))
        read = list(read_pieces(path))
        assert 3 < len(read) < len(whole) and read == whole[: len(read)]
        err = capsys.readouterr().err
        assert err.count("\n") == 1 and ("was cut off" in err or "is damaged" in err)


def test_raw_bytes_are_replayed_whatever_became_of_the_lines_beside(log, capsys):
    whole = list(read_pieces(log.with_suffix(".bin")))
    lines = log.with_suffix(".jsonl").read_bytes().splitlines(keepends=True)
    log.with_suffix(".jsonl").write_bytes(b"".join([*lines[:5], bytes(80) + b"\n", *lines[6:]]))
    read = list(read_pieces(log.with_suffix(".bin")))
    assert [piece.data for piece in read] == [piece.data for piece in whole]
    assert [k for k, piece in enumerate(read) if piece.time_s is None] == [5]
    log.with_suffix(".jsonl").write_bytes(bytes(1000))
    read = list(read_pieces(log.with_suffix(".bin")))
    assert [piece.data for piece in read] == [piece.data for piece in whole]
    assert "the times of the bytes beside are not known" in capsys.readouterr().err


def test_a_log_is_known_by_its_content_under_any_name(log, tmp_path):
    for suffix in (".jsonl", ".csv", ".mcap", ".bin"):
        pieces = list(read_pieces(log.with_suffix(suffix)))
        for name in ("copy.txt", "copy" + suffix.upper()):
            (tmp_path / name).write_bytes(log.with_suffix(suffix).read_bytes())
            assert [piece.data for piece in read_pieces(tmp_path / name)] == [piece.data for piece in pieces]


def test_what_is_no_log_is_given_up_early(tmp_path):
    (tmp_path / "a.jsonl").write_text("{}\n" * 300)
    with pytest.raises(UserError, match="a.jsonl line 1 is not from larics log"):
        list(read_objects(tmp_path / "a.jsonl"))


@pytest.mark.parametrize("number", ["1" + 400 * "0", "NaN", "1e999", "true", '"1"', "null", "[1]"])
@pytest.mark.parametrize("key", ["x", "heading", "margin", "id", "frame"])
def test_detections_that_cannot_be_are_refused(tmp_path, key, number):
    one = {"id": 3, "x": 1.5, "y": 2, "heading": 90, "radius": 30, "margin": 200}
    record = {"frame": "a.pgm", "detections": [one]}
    (record if key == "frame" else one)[key] = "here"
    (tmp_path / "a.jsonl").write_text(json.dumps(record).replace('"here"', number) + "\n")
    if (key, number) in (("id", "null"), ("frame", '"1"'), ("id", "1" + 400 * "0")):
        assert read_log(tmp_path / "a.jsonl").by_frame
        return
    with pytest.raises(UserError, match="a.jsonl line 1 is not from larics detect --json"):
        read_log(tmp_path / "a.jsonl")


def test_detections_that_end_early_are_refused(tmp_path):
    line = json.dumps({"frame": "a.pgm", "detections": []})
    (tmp_path / "a.jsonl").write_text(line + "\n\n" + line[:20])
    with pytest.raises(UserError, match="a.jsonl line 3 was cut off: write the file again"):
        read_log(tmp_path / "a.jsonl")


@pytest.mark.parametrize("extension", [".csv", ".jsonl"])
def test_a_log_from_before_the_uncertainty_is_read_with_it_unknown(tmp_path, extension):
    names = [name for name in ("time_s", "sequence", *Marker._fields) if not name.startswith("sigma_")]
    values = [1.5, 7, 3, 900, 0, 5, 0, 1, 10, -20, 30000, 4500, 200, 7700]
    path = tmp_path / ("old" + extension)
    if extension == ".csv":
        path.write_text("%s\n%s\n" % (",".join(names), ",".join(map(str, values))))
    else:
        path.write_text(json.dumps({"message": "MARKER", **dict(zip(names, values, strict=True))}) + "\n")
    (piece,) = read_pieces(path)
    (message,) = Receiver().feed(piece.data, 0.0)
    fields = message.fields
    assert (fields.id, fields.x_mm10, fields.radius_q8) == (5, 10, 7700)
    assert known(fields, "sigma_q12") is None and known(fields, "sigma_mdeg") is None


def test_a_log_that_lacks_anything_else_is_none(tmp_path):
    (tmp_path / "a.jsonl").write_text('{"message": "MARKER", "time_s": 1, "sequence": 1, "frame": 2}\n')
    with pytest.raises(UserError):
        list(read_pieces(tmp_path / "a.jsonl"))
