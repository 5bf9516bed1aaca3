"""Table of docs/measurements.md: the march's shader as compiled for real graphics processors, and its bounds.

    python3 .ci/compiled.py GPU_STATS BARNARD [PAGE]

GPU_STATS is a program that compiles without a device: `gpu_stats.sh -d DEVICES -m METHODS BARNARD SCENE...` prints a JSON list of what
each compiler says of the march. With a PAGE, the table between its marks `compiled` is written anew; without one, bounds are checked alone.
"""

import json
import subprocess
import sys

SCENES = ["barres_neyret", "barres_neyret_six_stars"]
METHODS = ["fixed_wavelength", "band_quadrature", "projection", "lookup"]
DEVICES = {"rx6800": "AMD RX 6800 (ACO)", "a100": "NVIDIA A100 (NAK)"}
# Most that the six-star march of the default method may take: what it took when this was written, and a tenth more.
BOUNDS = {
    ("rx6800", "VGPRs"): 79,
    ("rx6800", "Instructions"): 3060,
    ("a100", "Number of GPRs"): 148,
    ("a100", "Instruction count"): 4070,
}
# What no march may have at all.
NONE = ["Spilled SGPRs", "Spilled VGPRs", "Scratch size", "SLM size", "Spills to memory", "private_memory", "float64"]
COLUMNS = {
    "registers": ["VGPRs", "Number of GPRs"],
    "instructions": ["Instructions", "Instruction count"],
    "code [B]": ["Code size"],
    "reads of textures": ["texture_samples"],
    "exponentials": ["exponentials"],
    "private memory": ["private_memory"],
}


def compiled(gpu_stats, barnard):
    scenes = [f"crates/files/scenes/{scene}.toml" for scene in SCENES]
    command = [gpu_stats, "-d", ",".join(DEVICES), "-m", ",".join(METHODS), barnard, *scenes]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def complaints(rows):
    """Everything that a row has and should not."""
    found = []
    for row in rows:
        name = f"{row['scene']}, {row['method']}, {row['device']}"
        if "error" in row:
            found.append(f"{name}: {row['error']}")
        found += [f"{name}: {key} is {row[key]}, which should be none" for key in NONE if row.get(key, 0)]
        if (row["scene"], row["method"]) == ("barres_neyret_six_stars", "band_quadrature"):
            for (device, key), most in BOUNDS.items():
                if row["device"] == device and not row.get(key, most + 1) <= most:
                    found.append(f"{name}: {key} is {row.get(key)}, at most {most} is allowed")
    wanted = {(scene, method, device) for scene in SCENES for method in METHODS for device in DEVICES}
    missing = wanted - {(row["scene"], row["method"], row["device"]) for row in rows}
    return found + [f"{', '.join(row)}: nothing was compiled" for row in sorted(missing)]


def table(rows):
    lines = ["| scene | method | device | " + " | ".join(COLUMNS) + " |", "|---" * (3 + len(COLUMNS)) + "|"]
    for row in rows:
        cells = [str(next((row[key] for key in keys if key in row), "-")) for keys in COLUMNS.values()]
        lines.append(f"| {row['scene']} | {row['method']} | {DEVICES[row['device']]} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def self_check(rows):
    """Shows that the bounds can break."""
    six = next(row for row in rows if row["scene"] == SCENES[1] and row["method"] == "band_quadrature")
    assert complaints([{**row, "Scratch size": 16} for row in rows]), "scratch goes unseen"
    assert complaints([{**row, **{key: 10**6 for _, key in BOUNDS}} if row is six else row for row in rows]), "growth goes unseen"
    assert complaints(rows[1:]), "a missing row goes unseen"


def main(gpu_stats, barnard, page=None):
    rows = compiled(gpu_stats, barnard)
    print(table(rows))
    found = complaints(rows)
    if found:
        sys.exit("\n".join(found))
    self_check(rows)
    if page:
        text = open(page).read()
        before, rest = text.split("<!-- compiled -->\n")
        _, after = rest.split("<!-- /compiled -->\n")
        open(page, "w").write(f"{before}<!-- compiled -->\n{table(rows)}\n<!-- /compiled -->\n{after}")


main(*sys.argv[1:])
