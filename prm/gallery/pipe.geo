// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A quarter of a pipe junction: a branch set on a run pipe with a hole. Lengths in mm.
// gmsh -3 -order 2 -format msh41 -bin pipe.geo -o pipe.msh
SetFactory("OpenCASCADE");
R = 60; r = 50;    // run along x: outer and inner radius
B = 40; b = 32;    // branch along y
l = 130; h = 120;  // half length of the run, height of the branch's end
Cylinder(1) = {0, 0, 0, l, 0, 0, R};
Cylinder(2) = {-1, 0, 0, l + 2, 0, 0, r};
Cylinder(3) = {0, 0, 0, 0, h, 0, b};
BooleanDifference(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Cylinder(5) = {0, 0, 0, 0, h, 0, B};
Cylinder(6) = {0, -1, 0, 0, h + 2, 0, b};
Cylinder(7) = {-l, 0, 0, 2*l, 0, 0, R};
BooleanDifference(8) = { Volume{5}; Delete; }{ Volume{6, 7}; Delete; };
Box(9) = {0, -100, 0, 200, 300, 100};
Box(10) = {0, 1, 0, 200, 300, 100};
BooleanIntersection(11) = { Volume{4}; Delete; }{ Volume{9}; Delete; };
BooleanIntersection(12) = { Volume{8}; Delete; }{ Volume{10}; Delete; };

e = 0.01;
Physical Volume("run") = {11};
Physical Volume("branch") = {12};
Physical Surface("x plane") = Surface In BoundingBox{-e, -100, -e, e, 200, 100};
Physical Surface("z plane") = Surface In BoundingBox{-e, -100, -e, 200, 200, e};
Physical Surface("run end") = Surface In BoundingBox{l - e, -100, -e, l + e, 200, 100};
Physical Surface("branch end") = Surface In BoundingBox{-e, h - e, -e, 200, h + e, 100};
Physical Surface("run bore") = Surface In BoundingBox{-e, -r - e, -e, l + e, r + e, r + e};
Physical Surface("hole") = Surface In BoundingBox{-e, 30, -e, b + e, R + e, b + e};
Physical Surface("branch bore") = Surface In BoundingBox{-e, 49, -e, b + e, h + e, b + e};
Physical Surface("foot") = Surface In BoundingBox{-e, 44, -e, B + e, R + e, B + e};
Mesh.MeshSizeFromCurvature = 26;
Mesh.MeshSizeMax = 11;
Mesh.MeshSizeMin = 4;
MeshSize{ PointsOf{ Volume{12}; } } = 6;
Mesh.OptimizeThreshold = 0.4;
