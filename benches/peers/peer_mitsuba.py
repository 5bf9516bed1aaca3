"""Renders a scene by Mitsuba 3 (`volpathmis`), denoised by Open Image Denoise if asked."""

import mitsuba as mi

mi.set_variant("llvm_ad_rgb")

import numpy as np  # noqa: E402
from peer import Job, run  # noqa: E402
from scenes import ALBEDO, DISTANCE, FIELD_OF_VIEW, SIZE, intensity  # noqa: E402


def render(job: Job) -> np.ndarray:
    scene, light = job.scene, intensity()
    extinction = np.ascontiguousarray(job.cloud.transpose(2, 1, 0))[..., None] * (scene.extinction() / scene.extinction().max())
    medium = {
        "type": "heterogeneous",
        "albedo": {"type": "constvolume", "value": ALBEDO},
        "sigma_t": {
            "type": "gridvolume",
            "grid": mi.VolumeGrid(extinction.astype(np.float32)),
            "raw": True,
            "to_world": mi.ScalarTransform4f().translate([-1, -1, -1]).scale(2),
        },
        "scale": float(scene.extinction().max()),
        "phase": {"type": "hg", "g": scene.g} if scene.g else {"type": "isotropic"},
    }
    star = {
        "type": "point",
        "position": list(scene.star),
        "intensity": {"type": "rgb", "value": [float(value) for value in light / light[1]]},
    }
    if max(abs(x) for x in scene.star) < 1.0:
        star["medium"] = {"type": "ref", "id": "dust"}
    world = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpathmis", "max_depth": -1 if job.orders == "all" else 2, "rr_depth": 50},
            "sensor": {
                "type": "perspective",
                "fov": FIELD_OF_VIEW,
                "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, DISTANCE], target=[0, 0, 0], up=[0, 1, 0]),
                "film": {
                    "type": "hdrfilm",
                    "width": SIZE,
                    "height": SIZE,
                    "rfilter": {"type": "box"},
                    "pixel_format": "rgb",
                    "component_format": "float32",
                },
                "sampler": {"type": "independent"},
            },
            "dust": medium,
            "cube": {"type": "cube", "bsdf": {"type": "null"}, "interior": {"type": "ref", "id": "dust"}},
            "star": star,
        }
    )
    picture = np.array(mi.render(world, spp=job.samples))
    if job.denoise:
        from mitsuba_oidn import denoise

        picture = np.array(denoise(np.ascontiguousarray(picture, np.float32), hdr=True))
    return picture * light[1]


run(render)
