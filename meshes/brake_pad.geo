// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
// gmsh -3 brake_pad.geo -o brake_pad.msh
// A pad of a brake in metres: hexahedra in four layers of 3 mm.
Mesh.MshFileVersion = 2.2;
Mesh.RecombineAll = 1;
Mesh.Algorithm = 6;
Mesh.SubdivisionAlgorithm = 1;
size = 0.02;
Point(1) = {0.07, -0.02, 0, size};
Point(2) = {0.11, -0.02, 0, size};
Point(3) = {0.11, 0.02, 0, size};
Point(4) = {0.07, 0.02, 0, size};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
parts[] = Extrude {0, 0, -0.012} { Surface{1}; Layers{4}; Recombine; };
Physical Surface("lining", 1) = {1};
Physical Surface("back", 2) = {parts[0]};
Physical Surface("sides", 3) = {parts[2], parts[3], parts[4], parts[5]};
Physical Volume("pad", 1) = {parts[1]};
