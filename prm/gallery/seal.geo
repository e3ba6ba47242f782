// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A rubber profile between a frame and a lid of steel, in mm. gmsh -2 -format msh41 seal.geo -o seal.msh
SetFactory("OpenCASCADE");
Rectangle(1) = {-12, 0, 0, 24, 12};
Disk(2) = {-15, 6, 0, 4.5, 4};
Disk(3) = {15, 6, 0, 4.5, 4};
Disk(4) = {0, 6, 0, 5, 2.6};
BooleanDifference(5) = { Surface{1}; Delete; }{ Surface{2, 3, 4}; Delete; };
Rectangle(6) = {-16, -2, 0, 32, 2};
Rectangle(7) = {-13, 12, 0, 26, 2};
e = 0.01;
Physical Surface("profile") = {5};
Physical Surface("frame") = {6};
Physical Surface("lid") = {7};
Physical Curve("foot") = Curve In BoundingBox{-12 - e, -e, -e, 12 + e, e, e};
Physical Curve("head") = Curve In BoundingBox{-12 - e, 12 - e, -e, 12 + e, 12 + e, e};
Physical Curve("frame top") = Curve In BoundingBox{-16 - e, -e, -e, 16 + e, e, e};
Physical Curve("frame bottom") = Curve In BoundingBox{-16 - e, -2 - e, -e, 16 + e, -2 + e, e};
Physical Curve("lid bottom") = Curve In BoundingBox{-13 - e, 12 - e, -e, 13 + e, 12 + e, e};
Physical Curve("lid top") = Curve In BoundingBox{-13 - e, 14 - e, -e, 13 + e, 14 + e, e};
Mesh.MeshSizeMax = 1;
MeshSize{ PointsOf{ Surface{6, 7}; } } = 2;
