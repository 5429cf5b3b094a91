"""Opens a log of catena in rerun with the robot large and its curves beside it, or draws one instant of it.

    pip install rerun-sdk
    python rerun_view.py LOG.mcap                          the viewer
    python rerun_view.py LOG.mcap --png OUT.png --at 2.5   a picture, without a display

rerun shows logs without any of this (`rerun LOG.mcap`); this is the arrangement of the pictures in the documentation.
"""

import argparse
import os
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.encodings import ComponentSourceKind, VisualizerComponentMapping

APPLICATION = "catena"


def figures(name, topic, message, fields):
    """A view of fields of a message, which rerun does not draw by itself."""

    def curve(field):
        source = VisualizerComponentMapping(
            target="Scalars:scalars",
            source_kind=ComponentSourceKind.SourceComponent,
            source_component=f"{message}:message",
            selector=f".{field}",
        )
        return rr.SeriesLines(names=field).visualizer(mappings=[source])

    return rrb.TimeSeriesView(origin=topic, name=name, overrides={topic: [curve(field) for field in fields]})


def blueprint(eye, target):
    curves = [
        rrb.TimeSeriesView(origin="/joint_states/position", name="joint positions [rad, m]"),
        rrb.TimeSeriesView(origin="/joint_states/velocity", name="joint velocities [rad/s, m/s]"),
        figures("energy [J]", "/energy", "catena_msgs.msg.Energy", ["kinetic", "potential", "total"]),
        rrb.TextLogView(origin="/rosout", name="warnings"),
    ]
    robot = rrb.Spatial3DView(
        origin="/",
        name="robot",
        eye_controls=rrb.EyeControls3D(position=eye, look_target=target, eye_up=(0, 0, 1)),
    )
    return rrb.Blueprint(
        rrb.Horizontal(robot, rrb.Vertical(*curves), column_shares=[2, 1]),
        rrb.TimePanel(state="collapsed", timeline="message_log_time"),
        collapse_panels=True,
        auto_views=False,
    )


def triple(text):
    return tuple(float(word) for word in text.split(","))


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def draw(files, png, at):
    from rerun.experimental import ViewerClient

    port = free_port()
    command = ["rerun", "--headless", "--bind", "127.0.0.1", "--port", str(port), "--window-size", "1280x720"]
    # The command is a wrapper around the viewer: it gets a group of its own, so that both end.
    viewer = subprocess.Popen(
        [*command, "--expect-data-soon", *files],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        for attempt in range(100):
            try:
                client = ViewerClient(f"127.0.0.1:{port}")
                break
            except Exception:
                if attempt == 99:
                    raise
                time.sleep(0.2)
        # The viewer does not say when it has read everything.
        time.sleep(8)
        client.set_time("message_log_time", timestamp=at, play_state="paused")
        time.sleep(2)
        client.save_screenshot(str(png))
        for _ in range(50):
            if png.exists():
                return
            time.sleep(0.2)
        raise SystemExit(f"rerun has not drawn {png}")
    finally:
        os.killpg(viewer.pid, signal.SIGTERM)
        viewer.wait()


def main():
    parser = argparse.ArgumentParser(description="Shows a log of catena in rerun.")
    parser.add_argument("log", type=Path)
    parser.add_argument("--png", type=Path, help="draw a picture instead of opening the viewer")
    parser.add_argument("--at", type=float, default=0.0, help="its instant [s]")
    parser.add_argument("--eye", type=triple, default=(2.2, -2.2, 1.6), help="where to look from: x,y,z [m]")
    parser.add_argument("--target", type=triple, default=(0.0, 0.0, 0.4), help="what to look at: x,y,z [m]")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        recording, view = str(Path(folder) / "log.rrd"), str(Path(folder) / "view.rbl")
        # The log of a run that was killed has no index.
        convert = ["rerun", "mcap", "convert", "--recover", "--application-id", APPLICATION]
        convert += [str(arguments.log), "-o", recording]
        subprocess.run(convert, check=True)
        # Read first, because for a recording that is there already the viewer may have arranged something of its own.
        blueprint(arguments.eye, arguments.target).save(APPLICATION, view)
        if arguments.png:
            draw([view, recording], arguments.png.resolve(), arguments.at)
        else:
            subprocess.run(["rerun", view, recording], check=True)


if __name__ == "__main__":
    main()
