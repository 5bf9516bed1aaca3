"""Renders the glowing cloud by VTK's fixed-point ray caster with steps of `1 / samples` voxels."""

import numpy as np
import vtk
from peer import Job, run
from scenes import DISTANCE, FIELD_OF_VIEW, GLOW, SIZE, VOXELS
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy


def render(job: Job) -> np.ndarray:
    return np.stack([band(job, extinction) for extinction in job.scene.extinction()], axis=-1)


def band(job: Job, extinction: float) -> np.ndarray:
    """One band: opacity tables have no colour, so each band is a picture."""
    image = vtk.vtkImageData()
    image.SetDimensions(VOXELS, VOXELS, VOXELS)
    cell = 2.0 / VOXELS
    image.SetSpacing(cell, cell, cell)
    image.SetOrigin(*[0.5 * cell - 1.0] * 3)
    image.GetPointData().SetScalars(numpy_to_vtk(job.cloud.transpose(2, 1, 0).ravel(), deep=True))

    most = float(job.cloud.max())
    opacity, colour = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction()
    colour.AddRGBPoint(0.0, 1.0, 1.0, 1.0)
    for value in np.linspace(0.0, most, 1024):
        opacity.AddPoint(value, 1.0 - np.exp(-extinction * value * cell))
    properties = vtk.vtkVolumeProperty()
    properties.SetScalarOpacity(opacity)
    properties.SetScalarOpacityUnitDistance(cell)
    properties.SetColor(colour)
    properties.SetInterpolationTypeToLinear()
    properties.ShadeOff()
    caster = vtk.vtkFixedPointVolumeRayCastMapper()
    caster.SetInputData(image)
    caster.AutoAdjustSampleDistancesOff()
    caster.SetSampleDistance(cell / job.samples)
    caster.SetImageSampleDistance(1.0)
    volume = vtk.vtkVolume()
    volume.SetMapper(caster)
    volume.SetProperty(properties)

    view = vtk.vtkRenderer()
    view.AddVolume(volume)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(SIZE, SIZE)
    window.AddRenderer(view)
    camera = view.GetActiveCamera()
    camera.SetPosition(0.0, 0.0, DISTANCE)
    camera.SetFocalPoint(0.0, 0.0, 0.0)
    camera.SetViewAngle(FIELD_OF_VIEW)
    view.ResetCameraClippingRange()
    window.Render()
    grabber = vtk.vtkWindowToImageFilter()
    grabber.SetInput(window)
    grabber.ReadFrontBufferOff()
    grabber.Update()
    pixels = vtk_to_numpy(grabber.GetOutput().GetPointData().GetScalars()).reshape(SIZE, SIZE, 3)
    return pixels[::-1, :, 0] / 255.0 * GLOW


run(render)
