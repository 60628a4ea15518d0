"""Checks the exports in a directory with the programs that read them: the schemas of KML and GPX, evo, the reader of
MCAP. Prints one line for each; a failed assertion is an error."""

import json
import sys
from pathlib import Path

import fastkml
import gpx
import jsonschema
from evo.tools import file_interface
from lxml import etree
from mcap.reader import NonSeekingReader, make_reader

PLACE = Path(sys.argv[1])


def kml():
    # The schema of Google's extension, which imports that of KML 2.2.
    schemas = Path(fastkml.__file__).parent / "schema"
    schema = etree.XMLSchema(etree.parse(schemas / "kml22gx.xsd"))
    document = etree.parse(PLACE / "solution.kml")
    schema.assertValid(document)
    count = lambda name: len(document.findall(f".//{{*}}{name}"))
    assert count("when") == count("coord") == count("angles") > 1000
    print("kml", count("when"), "points valid")


def gpx_file():
    result = gpx.validate(PLACE / "solution.gpx")
    assert not result.issues, result.issues
    points = gpx.read_gpx(PLACE / "solution.gpx").trk[0].trkseg[0].trkpt
    times = [point.time for point in points]
    assert all(before < after for before, after in zip(times, times[1:]))
    print("gpx", len(points), "points valid")


def trajectories():
    tum = file_interface.read_tum_trajectory_file(PLACE / "solution.tum")
    euroc = file_interface.read_euroc_csv_trajectory(PLACE / "solution.euroc.csv")
    for trajectory in (tum, euroc):
        valid, details = trajectory.check()
        assert valid, details
    assert tum.num_poses == euroc.num_poses > 5000
    assert abs(tum.positions_xyz - euroc.positions_xyz).max() < 1e-4
    assert abs(tum.orientations_quat_wxyz - euroc.orientations_quat_wxyz).max() < 1e-6
    print("evo", tum.num_poses, "poses,", round(tum.path_length, 1), "m")


def mcap():
    path = PLACE / "solution.mcap"
    counts, last = {}, {}
    with open(path, "rb") as file:
        for schema, channel, message in NonSeekingReader(file, validate_crcs=True).iter_messages():
            content = json.loads(message.data)
            if channel.topic not in counts:
                shape = json.loads(schema.data)
                jsonschema.Draft7Validator.check_schema(shape)
                jsonschema.validate(content, shape)
            assert message.log_time >= last.get(channel.topic, 0)
            last[channel.topic] = message.log_time
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
    with open(path, "rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    told = {summary.channels[number].topic: count
            for number, count in summary.statistics.channel_message_counts.items()}
    assert told == counts, (told, counts)
    assert len(set(counts.values())) == 1, counts
    print("mcap", counts)
    layout(counts)


def layout(topics):
    content = json.loads((PLACE / "solution.foxglove-layout.json").read_text())
    panels = content["configById"]

    def leaves(tree):
        if isinstance(tree, str):
            return [tree]
        return leaves(tree["first"]) + leaves(tree["second"])

    shown = leaves(content["layout"])
    assert sorted(shown) == sorted(panels), (shown, list(panels))
    named = [word for word in json.dumps(panels).replace(".", '"').split('"') if word.startswith("/")]
    assert named and all(name in topics for name in named), named
    print("layout", len(shown), "panels of", ", ".join(sorted(set(named))))


kml()
gpx_file()
trajectories()
mcap()
