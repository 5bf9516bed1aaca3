"""Error against CPU time: `python plot.py FOLDER/measured.csv OUT.svg`."""

import csv
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

NAMES = {
    "barnard": ("Barnard", "#d95f02", "o"),
    "cycles": ("Cycles + OIDN", "#1b9e77", "s"),
    "mitsuba": ("Mitsuba + OIDN", "#7570b3", "^"),
    "vtk": ("VTK", "#666666", "D"),
}
PANELS = (
    ("inside", "one", "star inside, one scattering"),
    ("inside", "all", "star inside, all scatterings"),
    ("outside", "one", "star outside, one scattering"),
    ("outside", "all", "star outside, all scatterings"),
)
MEASURES = (("rms error", "relative rms error"), ("rms relative error", "rms relative error of pixels"))


def main() -> None:
    with open(sys.argv[1], newline="") as file:
        rows = list(csv.DictReader(file))
    plt.rcParams.update({"svg.hashsalt": "peers", "svg.fonttype": "none", "font.size": 9})
    figure, axes = plt.subplots(2, 4, figsize=(13, 6), sharex=True, sharey=True)
    for column, (scene, orders, title) in enumerate(PANELS):
        for row, (measure, label) in enumerate(MEASURES):
            axis = axes[row][column]
            for program, (name, colour, marker) in NAMES.items():
                mine = [r for r in rows if (r["program"], r["scene"], r["orders"]) == (program, scene, orders)]
                if mine:
                    points = [(float(r["CPU seconds"]), float(r[measure])) for r in mine]
                    axis.plot(*zip(*points), marker=marker, color=colour, label=name, markersize=4)
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.grid(True, which="major", alpha=0.3)
            if row == 0:
                axis.set_title(title, fontsize=9)
            else:
                axis.set_xlabel("CPU seconds")
            if column == 0:
                axis.set_ylabel(label)
    axes[0][0].legend(frameon=False, fontsize=8)
    figure.tight_layout()
    figure.savefig(sys.argv[2], metadata={"Date": None})


main()
