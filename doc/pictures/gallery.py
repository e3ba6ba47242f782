# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# The pictures of doc/gallery.md and of prm/tutorials/README.md. Run the scenes from the top level of the sources, then
#
#     python3 doc/pictures/gallery.py [NAME …]
#
# draws output/NAME/solution.pvd as doc/pictures/NAME.png (all scenes that have a result, or the named ones). It starts
# ParaView (5.11 or newer) for each picture, three times at most, on a display of its own where xvfb-run is installed.

import os
import shutil
import struct
import subprocess
import sys
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
WIDTH = 900
INK, EDGE = [0.13, 0.15, 0.18], [0.25, 0.25, 0.28]

# name: what is coloured (component: of a 3 x 3 tensor), its formula in the arrays of the output, title, colour map, factor
# of the displacement, height in pixels, camera (3D: direction and up), and more:
# limits, revolve (degrees by which a body of revolution is swept), zoom, step (index of the step; -1: last), bodies
HOT, STRESS = "Plasma (matplotlib)", "Viridis (matplotlib)"
PICTURES = {
    "bracket": dict(array="von Mises", title="von Mises stress [MPa]", map=STRESS, factor=50, height=620,
                    camera=([0.75, 0.5, 0.9], [0, 1, 0]), percentile=99.5),
    "pipe": dict(array="von Mises", title="von Mises stress [MPa]", map=STRESS, factor=100, height=620,
                 camera=([0.3, 0.35, -0.9], [0, 1, 0]), percentile=99),
    "heat_sink": dict(array="temperature", formula="temperature - 273.15", title="temperature [°C]", map=HOT, height=620,
                      camera=([-0.8, 0.12, -0.9], [0, 1, 0])),
    "flange": dict(array="von Mises", title="von Mises stress [MPa]", map=STRESS, factor=100, height=620, revolve=240,
                   camera=([0.5, -0.87, 0.5], [0, 0, 1]), percentile=99.8),
    "bush": dict(array="von Mises", title="von Mises stress [MPa]", map=STRESS, factor=1, height=620, revolve=240,
                 camera=([0.5, -0.87, 0.5], [0, 0, 1]), bodies_of_colour=["rubber"], percentile=99.5),
    "brake": dict(array="temperature", title="temperature at 2 s [°C]", map=HOT, height=560, revolve=230, step=1,
                  camera=([0.42, -0.9, 0.6], [0, 0, 1])),
    "shrink_fit": dict(array="von Mises", title="von Mises stress [MPa]", map=STRESS, height=640),
    "tubular_seal": dict(array="von Mises", title="von Mises stress [MPa]", map=STRESS, factor=1, height=480,
                         bodies_of_colour=["seal"], percentile=99.5),
    "seal": dict(array="von Mises", title="von Mises stress [MPa]", map=STRESS, factor=1, height=480,
                 bodies_of_colour=["profile"], percentile=99.5),
    "bimetal": dict(array="Cauchy stress", component=0, divide=1e6, title="stress along the strip [MPa]",
                    map="Cool to Warm", factor=2, height=300),
    "laminated_beam": dict(array="Cauchy stress", component=0, title="stress along x [MPa]",
                           map="Cool to Warm", factor=10, height=380, symmetric=True),
    "periodic_cell": dict(array="temperature", title="temperature [K]", map=HOT, height=580, copies=3),
    "01_two_blocks": dict(array="temperature", title="temperature [K]", map=HOT, height=620),
    "02_sandwich": dict(array="von Mises", formula='"von Mises"/1e6', title="von Mises stress [MPa]", map=STRESS, factor=1,
                        height=380, percentile=99),
    "03_curved_seam": dict(array="von Mises", formula='"von Mises"/1e6', title="von Mises stress [MPa]", map=STRESS, factor=50,
                           height=640),
    "04_every_tie": dict(array="temperature", title="temperature [K]", map=HOT, height=560,
                         camera=([0.8, -1.1, 0.6], [0, 0, 1])),
    "06_in_time": dict(array="temperature", title="temperature at the end [°C]", map=HOT, height=330),
}


def main():
    names = sys.argv[1:] or [n for n in PICTURES if os.path.exists("output/%s/solution.pvd" % n)]
    prefix = ["xvfb-run", "-a"] if shutil.which("xvfb-run") else []
    missing = []
    for name in names:
        target = os.path.join(HERE, name + ".png")
        for _ in range(3):
            try:
                subprocess.run(prefix + ["pvbatch", os.path.abspath(__file__), "--draw", name, target], timeout=180,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=True)
                break
            except (subprocess.TimeoutExpired, subprocess.CalledProcessError) as error:
                print("%s: %s" % (name, error.stderr.decode()[-300:]), file=sys.stderr)
        else:
            missing.append(name)
            continue
        print(target)
    if missing:
        sys.exit("no picture of " + ", ".join(missing))


def find(producer, name):
    """POINTS or CELLS, wherever the array is, or None."""
    if name in producer.PointData.keys():
        return "POINTS"
    return "CELLS" if name in producer.CellData.keys() else None


def prepared(block, spec):
    """The body, deformed, with the array 'shown', copied or turned upright."""
    from paraview.simple import AppendDatasets, Calculator, PythonCalculator, Transform, WarpByVector
    body = block
    if spec.get("factor"):
        body = WarpByVector(Input=body, Vectors=["POINTS", "displacement"], ScaleFactor=spec["factor"])
        body.UpdatePipeline()
    kind = "Point Data" if find(body, spec["array"]) == "POINTS" else "Cell Data"
    if "component" in spec:
        body = PythonCalculator(Input=body, ArrayName="shown", ArrayAssociation=kind,
                                Expression="inputs[0].%s['%s'].reshape(-1, 9)[:, %d]/%g" % (
                                    kind.replace(" ", ""), spec["array"], spec["component"], spec.get("divide", 1)))
    else:
        body = Calculator(Input=body, ResultArrayName="shown", AttributeType=kind,
                          Function=spec.get("formula", '"%s"' % spec["array"]))
    body.UpdatePipeline()
    if spec.get("copies"):
        parts = []
        for i in range(spec["copies"]):
            for j in range(spec["copies"]):
                part = Calculator(Input=body, ResultArrayName="shown", Function='"%s" - %d' % (spec["array"], i))
                part = Transform(Input=part, Transform="Transform")
                part.Transform.Translate = [i, j, 0]
                parts.append(part)
        body = AppendDatasets(Input=parts)
        body.UpdatePipeline()
    if spec.get("revolve"):
        body = Transform(Input=body, Transform="Transform")
        body.Transform.Rotate = [90, 0, 0]
        body.UpdatePipeline()
    return body


def swept(body, spec):
    """A body of revolution in the half plane y = 0: its skin, and the half plane at the end of the sweep."""
    from paraview.simple import ExtractSurface, GenerateSurfaceNormals, RotationalExtrusion, Transform
    skin = RotationalExtrusion(Input=ExtractSurface(Input=body), Resolution=90, Angle=spec["revolve"], Capping=0)
    skin = GenerateSurfaceNormals(Input=skin, FeatureAngle=30)
    end = Transform(Input=body, Transform="Transform")
    end.Transform.Rotate = [0, 0, spec["revolve"]]
    for part in (skin, end):
        part.UpdatePipeline()
    return skin, end


def limits_of(bodies, spec):
    from paraview import numpy_support, servermanager
    import numpy
    parts = []
    for body in bodies:
        data = servermanager.Fetch(body)
        of = data.GetPointData() if find(body, "shown") == "POINTS" else data.GetCellData()
        parts.append(numpy_support.vtk_to_numpy(of.GetArray("shown")))
    values = numpy.concatenate(parts)
    low, high = values.min(), numpy.percentile(values, spec.get("percentile", 100))
    if spec.get("symmetric"):
        high = max(abs(low), abs(high))
        low = -high
    return ([0, high] if spec["map"] == STRESS else [low, high])


def draw(name, target):
    from paraview.simple import (ColorBy, CreateView, ExtractBlock, GetAnimationScene, GetColorTransferFunction,
                                 GetScalarBar, MergeBlocks, PVDReader, RenderAllViews, ResetCamera, SaveScreenshot, Show)
    import json
    spec = PICTURES[name]
    folder = "output/%s/" % name
    reader = PVDReader(FileName=folder + "solution.pvd")
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues)
    if times:
        GetAnimationScene().AnimationTime = times[spec.get("step", -1)]
        reader.UpdatePipeline(times[spec.get("step", -1)])
    with open(folder + "report.json") as report:
        names = list(json.load(report)["domains"])
    bodies = {}
    for body in names:
        block = MergeBlocks(Input=ExtractBlock(Input=reader, Selectors=["//" + body.replace(" ", "_"), "//" + body.replace(" ", "")]))
        block.UpdatePipeline()
        if block.GetDataInformation().GetNumberOfCells() == 0:
            sys.exit("no block " + body)
        bodies[body] = prepared(block, spec)

    view = CreateView("RenderView")
    view.ViewSize = [WIDTH, spec["height"]]
    view.UseColorPaletteForBackground, view.Background, view.OrientationAxesVisibility = 0, [1, 1, 1], 0
    coloured = spec.get("bodies_of_colour", names)
    limits = limits_of([bodies[body] for body in coloured], spec)
    table = GetColorTransferFunction("shown")
    table.ApplyPreset(spec["map"], True)
    parts = [(body, bodies[body], True) for body in names]
    if spec.get("revolve"):
        for body in names:
            skin, end = swept(bodies[body], spec)
            parts += [(body, skin, False), (body, end, True)]
    for body, part, has_edges in parts:
        shown = Show(part, view)
        shown.Representation = "Surface With Edges" if has_edges else "Surface"
        shown.EdgeColor, shown.LineWidth, shown.Ambient, shown.Diffuse = EDGE, 1, 0.3, 0.75
        if body in coloured:
            ColorBy(shown, (find(part, "shown"), "shown"))
        else:
            ColorBy(shown, None)
            shown.AmbientColor = shown.DiffuseColor = [0.72, 0.74, 0.77]
    table.RescaleTransferFunction(*limits)
    bar = GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = spec["title"], ""
    bar.TitleColor = bar.LabelColor = INK
    bar.TitleFontSize, bar.LabelFontSize = 16, 15
    fine = limits[1] - limits[0] < 10
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, "%.1f" if fine else "%.0f", "%.1f" if fine else "%.0f"
    bar.Orientation, bar.WindowLocation = "Horizontal", "Lower Center"
    bar.ScalarBarLength, bar.ScalarBarThickness, bar.Visibility = 0.45, 14, 1

    RenderAllViews()
    view.CameraParallelProjection = 1
    if spec.get("camera"):
        direction, up = spec["camera"]
        view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = direction, [0, 0, 0], up
    else:
        view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [0, 0, 1], [0, 0, 0], [0, 1, 0]
    ResetCamera(view)
    fit(view, [part for _, part, _ in parts], spec)
    SaveScreenshot(target, view, ImageResolution=[WIDTH, spec["height"]])
    make_small(target)


def make_small(path, colours=200):
    """Write the PNG again with a palette."""
    import numpy
    from paraview import numpy_support
    from vtkmodules.vtkIOImage import vtkPNGReader
    from vtkmodules.vtkImagingColor import vtkImageQuantizeRGBToIndex
    reader = vtkPNGReader()
    reader.SetFileName(path)
    quantize = vtkImageQuantizeRGBToIndex()
    quantize.SetInputConnection(reader.GetOutputPort())
    quantize.SetNumberOfColors(colours)
    quantize.Update()
    width, height, _ = quantize.GetOutput().GetDimensions()
    index = numpy_support.vtk_to_numpy(quantize.GetOutput().GetPointData().GetScalars()).astype(numpy.uint8)
    lookup = quantize.GetLookupTable()
    palette = bytes(int(255 * lookup.GetTableValue(i)[c] + 0.5) for i in range(colours) for c in range(3))
    rows = b"".join(b"\0" + row.tobytes() for row in index.reshape(height, width)[::-1])
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)), (b"PLTE", palette),
                           (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")):
            file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


def fit(view, bodies, spec):
    """Fill the picture above the colour bar with the bodies."""
    import numpy
    corners = []
    for body in bodies:
        b = body.GetDataInformation().GetBounds()
        corners += [[b[i], b[2 + j], b[4 + k]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    corners = numpy.array(corners)
    forward = numpy.array(view.CameraFocalPoint) - numpy.array(view.CameraPosition)
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(forward, numpy.array(view.CameraViewUp))
    right /= numpy.linalg.norm(right)
    up = numpy.cross(right, forward)
    across, along = corners @ right, corners @ up
    bar = 85 / spec["height"]  # share of the picture
    half = max((along.max() - along.min()) / 2 / (1 - bar - 0.03), (across.max() - across.min()) / 2 * spec["height"] / WIDTH / 0.96)
    middle = right * (across.max() + across.min()) / 2 + up * ((along.max() + along.min()) / 2 - half * (bar - 0.01)) \
        + forward * (corners @ forward).mean()
    distance = 10 * half
    view.CameraFocalPoint = list(middle)
    view.CameraPosition = list(middle - forward * distance)
    view.CameraParallelScale = half / spec.get("zoom", 1)


if __name__ == "__main__":
    if len(sys.argv) == 4 and sys.argv[1] == "--draw":
        draw(sys.argv[2], sys.argv[3])
    else:
        main()
