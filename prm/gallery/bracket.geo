// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// An angle bracket of steel, bolted to a wall plate of aluminium: the bracket and the plate are two volumes whose meshes
// know nothing of each other. Lengths in mm. gmsh -3 -order 2 -format msh41 -bin bracket.geo -o bracket.msh
SetFactory("OpenCASCADE");
// bracket: leg along the wall (y from 0 to 60), arm (x from 0 to 70), width z from -20 to 20, 8 thick, fillet of radius 10
Box(1) = {0, 0, -20, 8, 60, 40};
Box(2) = {0, 0, -20, 70, 8, 40};
Box(3) = {8, 8, -20, 10, 10, 40};
Cylinder(4) = {18, 18, -20, 0, 0, 40, 10};
BooleanDifference(5) = { Volume{3}; Delete; }{ Volume{4}; Delete; };
BooleanUnion(6) = { Volume{1}; Delete; }{ Volume{2, 5}; Delete; };
Cylinder(7) = {52, -1, 0, 0, 10, 0, 7};
BooleanDifference(8) = { Volume{6}; Delete; }{ Volume{7}; Delete; };
// plate behind it
Box(9) = {-10, -15, -30, 10, 90, 60};

e = 0.01;
Physical Volume("bracket") = {8};
Physical Volume("plate") = {9};
back() = Surface In BoundingBox{-e, -e, -20 - e, e, 60 + e, 20 + e};
Physical Surface("back") = {back()};
Physical Surface("hole") = Surface In BoundingBox{45 - e, -e, -7 - e, 59 + e, 8 + e, 7 + e};
Physical Surface("wall") = Surface In BoundingBox{-10 - e, -15 - e, -30 - e, -10 + e, 75 + e, 30 + e};
Physical Surface("front") = Surface In BoundingBox{-e, -15 - e, -30 - e, e, 75 + e, 30 + e};
Mesh.MeshSizeMax = 9;
Mesh.MeshSizeFromCurvature = 12;
MeshSize{ PointsOf{ Volume{9}; } } = 15;
