"""A nebula that three instruments record, and what is found of it: python docs/observing/fitted.py writes masters, a table and a picture."""

import time

import barnard as bn
import matplotlib.pyplot as plt
import numpy as np

FREE = {
    "star[0].luminosity": None,
    "star[0].temperature": bn.Free("8000 K", "40000 K"),
    "star[1].luminosity": None,
    "emission[0].scale": None,
    "background.radiance": None,
    "dust.scale": bn.Free(2, 20),
}
#: What the images are made of, and where the fit begins.
TRUTH = {"star[0].luminosity": 900, "star[0].temperature": 16000, "star[1].luminosity": 500, "emission[0].scale": 1e-24, "background.radiance": 3e-8, "dust.scale": 8}
BEGIN = {"star[0].luminosity": 300, "star[0].temperature": 25000, "star[1].luminosity": 1500, "emission[0].scale": 3e-24, "background.radiance": 1e-8, "dust.scale": 5}
#: Pixels along a row and a column of each image.
SIZE = 256
#: Name, passbands, pixel scale [arcsec], instrument.
INSTRUMENTS = [
    ("hubble", ["hst-wfc3-f438w", "hst-wfc3-f606w", "hst-wfc3-f814w"], 0.24, bn.Instrument(preset="hst-wfc3-uvis", exposure="40 s", frames=4)),
    ("one_metre", "johnson", 0.6, bn.Instrument(preset="lco-1m-sinistro", exposure="60 s", frames=6)),
    ("rubin", ["lsst2023-g", "lsst2023-r", "lsst2023-i"], 0.5, bn.Instrument(preset="rubin-lsstcam", exposure="3 s", frames=2)),
]


def scene(values):
    """A cloud with two young stars in it, gas that glows, and light behind, at 2 kpc."""
    nebula = bn.Scene(bands="johnson", name="nebula", method=bn.Method(bake=160))
    nebula.camera = bn.PerspectiveCamera("0 0 2000 pc", "140 arcsec", size=SIZE)
    nebula.fields["cloud"] = bn.Turbulence(seed=5, low="-0.6 -0.6 -0.6 pc", high="0.6 0.6 0.6 pc", voxels=160, outer_scale="0.6 pc", mach=8)
    nebula.fields["ball"] = bn.Plummer(core="0.22 pc", cut="0.55 pc")
    nebula.dust = bn.Dust("cloud * ball", f"{values['dust.scale']} /pc", law="gordon23", albedo=0.6)
    places = ["0.1 0.05 0.2 pc", "-0.2 -0.1 0.15 pc"]
    temperatures = [values["star[0].temperature"], 20000]
    for i, (place, temperature) in enumerate(zip(places, temperatures)):
        luminosity = values[f"star[{i}].luminosity"]
        nebula.stars.append(bn.Star(place, temperature=f"{temperature} K", luminosity=f"{luminosity} Lsun", visible=False))
    lines = [{"wavelength": "500.7 nm", "strength": 1}, {"wavelength": "656.3 nm", "strength": 1.5}]
    nebula.emission.append(bn.LinesEmission(density="cloud * ball", scale=f"{values['emission[0].scale']} W/m3/sr", lines=lines))
    nebula.background = bn.BlackbodyBackground(temperature="4500 K", radiance=f"{values['background.radiance']} W/m2/sr/um")
    nebula.display = bn.Display(stretch="asinh", strength=8)
    return nebula


images = []
for name, bands, scale, instrument in INSTRUMENTS:
    instrument.pixel_scale = f"{scale} arcsec"
    parts = {"bands": bands, "camera": bn.PerspectiveCamera("0 0 2000 pc", f"{scale * SIZE:g} arcsec", size=SIZE), "instrument": instrument}
    truth = scene(TRUTH)
    for key, value in parts.items():
        setattr(truth, key, value)
    master = truth.render().observe().master()
    master.write(f"{name}.fits")
    master.write(f"{name}.png")
    images.append((f"{name}.fits", parts))
start = time.perf_counter()
fit = scene(BEGIN).fit(FREE, images, progress=True)
print(fit, f"{fit.pictures} pictures, {time.perf_counter() - start:.1f} s", sep="\n")
for key, value in fit.values.items():
    print(f"| `{key}` | {TRUTH[key]:g} | {BEGIN[key]:g} | {value:.5g} ± {fit.sigma[key]:.2g} {fit.units[key]} | {(value - TRUTH[key]) / fit.sigma[key]:+.1f} |")

figure, axes = plt.subplots(2, 3, figsize=(9, 6), gridspec_kw={"wspace": 0.03, "hspace": 0.03, "left": 0, "right": 1, "bottom": 0, "top": 1})
for column, ((name, *_), left) in enumerate(zip(INSTRUMENTS, fit.residuals)):
    band = left.bands[1]
    axes[0, column].imshow(plt.imread(f"{name}.png"))
    axes[1, column].imshow(np.asarray(left[band]) / np.asarray(left[f"{band}_error"]), vmin=-5, vmax=5, cmap="RdBu_r")
    axes[1, column].text(6, 18, f"{band}: data minus model, ±5 σ", fontsize=9)
    for axis in axes[:, column]:
        axis.axis("off")
figure.savefig("fitted.jpg", dpi=110)
