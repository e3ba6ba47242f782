// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The cell of a composite: a square of matrix with a round hole, and the fibre in it, of curved triangles. The fibres fill 40 %.
// gmsh -2 -order 2 -format msh41 periodic_cell.geo -o periodic_cell.msh
SetFactory("OpenCASCADE");
a = Sqrt(0.4/Pi);
Rectangle(1) = {-0.5, -0.5, 0, 1, 1};
Disk(2) = {0, 0, 0, a};
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
Disk(4) = {0, 0, 0, a};
Rotate{{0, 0, 1}, {0, 0, 0}, 0.1}{ Surface{4}; }
e = 0.001;
Physical Surface("matrix") = {3};
Physical Surface("fibre") = {4};
Physical Curve("left") = Curve In BoundingBox{-0.5 - e, -0.5 - e, -e, -0.5 + e, 0.5 + e, e};
Physical Curve("right") = Curve In BoundingBox{0.5 - e, -0.5 - e, -e, 0.5 + e, 0.5 + e, e};
Physical Curve("bottom") = Curve In BoundingBox{-0.5 - e, -0.5 - e, -e, 0.5 + e, -0.5 + e, e};
Physical Curve("top") = Curve In BoundingBox{-0.5 - e, 0.5 - e, -e, 0.5 + e, 0.5 + e, e};
Physical Curve("rim") = Curve In BoundingBox{-a - e, -a - e, -e, a + e, a + e, e};
Mesh.MeshSizeMax = 0.11;
fibre() = Boundary{ Surface{4}; };
hole() = Curve In BoundingBox{-a - e, -a - e, -e, a + e, a + e, e};
hole() -= {fibre()};
Transfinite Curve{hole()} = 27;
Transfinite Curve{fibre()} = 20;
