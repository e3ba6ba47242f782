# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# The picture of the quick start, blade and disk deformed: on the left the temperature, on the right the joint from the
# front with the von Mises stress (or the temperature again, where the output has no stress). ParaView 5.11 or newer:
#
#     pvbatch doc/pictures/quick_start.py output/quick_start/solution.pvd doc/pictures/quick_start.png
#
# ParaView needs a display; on a machine without one put 'xvfb-run -a' in front.

import sys

from paraview import numpy_support
from paraview.simple import *
import numpy

BODIES = ("blade", "disk")  # the blocks to show; those of the interfaces are left out
DRAWN_SHIFT = 0.008  # m: the displacement is exaggerated so that the largest is drawn about this long
SIZE = [1200, 800]
INK, EDGE = [0.13, 0.15, 0.18], [0.20, 0.20, 0.22]


def find(producer, name):
    """POINTS or CELLS, wherever the array is, or None."""
    if name in producer.PointData.keys():
        return "POINTS"
    return "CELLS" if name in producer.CellData.keys() else None


def values(producers, name):
    """The array on all bodies; the length of vectors."""
    parts = []
    for producer in producers:
        data = servermanager.Fetch(producer)
        of = data.GetPointData() if find(producer, name) == "POINTS" else data.GetCellData()
        array = numpy_support.vtk_to_numpy(of.GetArray(name))
        parts.append(numpy.linalg.norm(array, axis=1) if array.ndim > 1 else array.copy())
    return numpy.concatenate(parts)


def scale_for(largest):
    """How much to exaggerate: 1, 2 or 5 times a power of ten, never less than 1."""
    wanted = DRAWN_SHIFT / largest if largest > 0 else 1
    power = 10 ** numpy.floor(numpy.log10(wanted))
    return max(1, max(step for step in (power, 2 * power, 5 * power) if step <= wanted * 1.0001))


def new_view(title):
    view = CreateView("RenderView")
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesVisibility = 0
    caption = Show(Text(Text=title), view)
    caption.Color, caption.FontSize, caption.Bold = INK, 15, 1
    caption.WindowLocation = "Upper Left Corner"
    return view


def look(view, position, focus, height):
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = position, focus, [0, 1, 0]
    view.CameraParallelProjection, view.CameraParallelScale = 1, height / 2


def colour(view, producers, name, title, preset, limits, place):
    """Show the producers coloured by the array, with mesh edges and a colour bar."""
    table = GetColorTransferFunction(name)
    table.ApplyPreset(preset, True)
    for producer in producers:
        shown = Show(producer, view)
        shown.Representation = "Surface With Edges"
        shown.EdgeColor, shown.LineWidth = EDGE, 1
        shown.Ambient, shown.Diffuse = 0.25, 0.8
        ColorBy(shown, (find(producer, name), name))
    table.RescaleTransferFunction(*limits)  # last, since ColorBy takes the limits of what it shows
    bar = GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = title, ""
    bar.TitleColor = bar.LabelColor = INK
    bar.TitleFontSize, bar.LabelFontSize = 14, 13
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, "%.0f", "%.0f"
    bar.Orientation, bar.WindowLocation = "Vertical", "Any Location"
    bar.Position, bar.ScalarBarLength, bar.ScalarBarThickness = place, 0.4, 14
    bar.Visibility = 1


if len(sys.argv) != 3:
    sys.exit("usage: pvbatch quick_start.py solution.pvd picture.png")
reader = PVDReader(FileName=sys.argv[1])
reader.UpdatePipelineInformation()
if len(reader.TimestepValues) > 0:
    GetAnimationScene().AnimationTime = reader.TimestepValues[-1]
    reader.UpdatePipeline(reader.TimestepValues[-1])

bodies = []
for name in BODIES:
    body = MergeBlocks(Input=ExtractBlock(Input=reader, Selectors=["//" + name]))
    body.UpdatePipeline()
    if body.GetDataInformation().GetNumberOfCells() == 0 or find(body, "temperature") is None:
        sys.exit(sys.argv[1] + " has no block '" + name + "' with a temperature.")
    bodies.append(body)

factor = scale_for(values(bodies, "displacement").max())
deformed = [WarpByVector(Input=body, Vectors=["POINTS", "displacement"], ScaleFactor=factor) for body in bodies]
for body in deformed:
    body.UpdatePipeline()
has_stress = all(find(body, "von Mises") for body in deformed)
if has_stress:
    for i, body in enumerate(deformed):
        deformed[i] = Calculator(Input=body, ResultArrayName="stress", Function='"von Mises"/1e6',
                                 AttributeType="Point Data" if find(body, "von Mises") == "POINTS" else "Cell Data")
        deformed[i].UpdatePipeline()

# The whole
kelvin = values(bodies, "temperature")
temperature = ("temperature", "temperature [K]", "Plasma (matplotlib)", [kelvin.min(), kelvin.max()])
whole = new_view("Temperature (displacement × %g)" % factor)
colour(whole, deformed, *temperature, [0.80, 0.30])

# The joint from the front. A corner can be singular: the colours end where one value in a hundred is larger
if has_stress:
    megapascal = values(deformed, "stress")
    stress = ("stress", "von Mises [MPa]", "Viridis (matplotlib)", [0, numpy.percentile(megapascal, 99)])
    joint = new_view("Von Mises stress at the joint")
    colour(joint, deformed, *stress, [0.86, 0.30])
else:
    joint = new_view("Temperature at the joint")
    colour(joint, deformed, *temperature, [0.86, 0.30])

layout = CreateLayout("quick start")
layout.SplitHorizontal(0, 0.42)
layout.AssignView(1, whole)
layout.AssignView(2, joint)
layout.SetSize(*SIZE)
RenderAllViews()  # sets cameras of its own: look() comes after it
look(whole, [0.47, 0.44, 0.95], [0.012, 0.1475, 0], 0.195)
middle = 0.142 * (1 + factor * 0.004)
look(joint, [0.10, middle + 0.14, 0.9], [0.006, middle, 0], 0.072)
SaveScreenshot(sys.argv[2], layout, ImageResolution=SIZE, SeparatorWidth=0)
