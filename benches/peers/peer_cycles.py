"""Renders a scene by Blender's Cycles, denoised by Open Image Denoise if asked."""

import sys
from pathlib import Path

import bpy

sys.path.append(str(next(Path(bpy.__file__).parents[3].glob("python/lib/python*/site-packages"))))

import numpy as np  # noqa: E402
import openvdb  # noqa: E402
from peer import Job, run  # noqa: E402
from scenes import ALBEDO, DISTANCE, FIELD_OF_VIEW, SIZE, VOXELS, intensity  # noqa: E402


def render(job: Job) -> np.ndarray:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    world = bpy.context.scene
    light = intensity()

    def add(name, data):
        thing = bpy.data.objects.new(name, data)
        world.collection.objects.link(thing)
        return thing

    grid = openvdb.FloatGrid()
    grid.copyFromArray(job.cloud)
    cell = 2.0 / VOXELS
    grid.transform = openvdb.createLinearTransform([[cell, 0, 0, 0], [0, cell, 0, 0], [0, 0, cell, 0], [0.5 * cell - 1.0] * 3 + [1]])
    grid.name = "density"
    file = job.out.with_suffix(".vdb")
    openvdb.write(str(file), grids=[grid])
    volume = bpy.data.volumes.new("cloud")
    volume.filepath = str(file)
    volume.materials.append(dust(job.scene))
    add("cloud", volume)

    star = bpy.data.lights.new("star", "POINT")
    star.shadow_soft_size = 0.0
    # A point light of 4 pi watts has the radiant intensity 1.
    star.energy = 4.0 * np.pi
    star.color = light / light[1]
    star.use_custom_distance = False
    add("star", star).location = job.scene.star

    eye = bpy.data.cameras.new("eye")
    eye.angle = np.radians(FIELD_OF_VIEW)
    eye.clip_end = 100.0
    world.camera = add("eye", eye)
    world.camera.location = (0.0, 0.0, DISTANCE)

    world.render.engine = "CYCLES"
    world.render.resolution_x = world.render.resolution_y = SIZE
    world.render.resolution_percentage = 100
    world.view_settings.view_transform = "Raw"
    settings = world.cycles
    settings.samples = job.samples
    settings.use_adaptive_sampling = False
    settings.pixel_filter_type, settings.filter_width = "BOX", 1.0
    settings.sample_clamp_direct = settings.sample_clamp_indirect = 0.0
    settings.light_sampling_threshold = 0.0
    settings.volume_biased = False
    settings.max_bounces = settings.volume_bounces = 1024 if job.orders == "all" else 0
    settings.use_denoising = job.denoise
    if job.denoise:
        settings.denoiser, settings.denoising_input_passes = "OPENIMAGEDENOISE", "RGB"

    image = job.out.with_suffix(".exr")
    world.render.filepath = str(image)
    world.render.image_settings.file_format = "OPEN_EXR"
    world.render.image_settings.color_depth = "32"
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(str(image))
    picture.colorspace_settings.name = "Non-Color"
    pixels = np.empty(SIZE * SIZE * 4, np.float32)
    picture.pixels.foreach_get(pixels)
    return pixels.reshape(SIZE, SIZE, 4)[::-1, :, :3].astype(float) * light[1]


def dust(scene):
    """Scattering and absorption, whose colours have the extinction of each band."""
    material = bpy.data.materials.new("dust")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    density, scale, both, out = (
        nodes.new(kind) for kind in ("ShaderNodeAttribute", "ShaderNodeMath", "ShaderNodeAddShader", "ShaderNodeOutputMaterial")
    )
    density.attribute_name = "density"
    scale.operation = "MULTIPLY"
    scale.inputs[1].default_value = scene.extinction().max()
    links.new(density.outputs["Fac"], scale.inputs[0])
    share = scene.extinction() / scene.extinction().max()
    for place, (kind, colour) in enumerate(
        (("ShaderNodeVolumeScatter", ALBEDO * share), ("ShaderNodeVolumeAbsorption", 1.0 - (1.0 - ALBEDO) * share))
    ):
        shader = nodes.new(kind)
        shader.inputs["Color"].default_value = (*colour, 1.0)
        if "Anisotropy" in shader.inputs:
            shader.inputs["Anisotropy"].default_value = scene.g
        links.new(scale.outputs[0], shader.inputs["Density"])
        links.new(shader.outputs[0], both.inputs[place])
    links.new(both.outputs[0], out.inputs["Volume"])
    return material


run(render)
