// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
// gmsh -3 brake_disc.geo -o brake_disc.msh
// The disc of a brake in metres: a ring of hexahedra over an unstructured mesh of quadrilaterals.
Mesh.MshFileVersion = 2.2;
Mesh.RecombineAll = 1;
Mesh.Algorithm = 6;
Mesh.SubdivisionAlgorithm = 1;
inner = 0.06; outer = 0.12; thick = 0.012; size = 0.044;
Point(1) = {0, 0, 0, size};
radii[] = {inner, outer};
For i In {0 : 1}
  r = radii[i];
  Point(10*i + 11) = {r, 0, 0, size};
  Point(10*i + 12) = {0, r, 0, size};
  Point(10*i + 13) = {-r, 0, 0, size};
  Point(10*i + 14) = {0, -r, 0, size};
  For j In {0 : 3}
    Circle(10*i + 11 + j) = {10*i + 11 + j, 1, 10*i + 11 + (j + 1)%4};
  EndFor
EndFor
Curve Loop(1) = {21, 22, 23, 24};
Curve Loop(2) = {11, 12, 13, 14};
Plane Surface(1) = {1, 2};
parts[] = Extrude {0, 0, thick} { Surface{1}; Layers{2}; Recombine; };
Physical Surface("inner face", 1) = {1};
Physical Surface("outer face", 2) = {parts[0]};
Physical Surface("rim", 3) = {parts[2], parts[3], parts[4], parts[5]};
Physical Surface("bore", 4) = {parts[6], parts[7], parts[8], parts[9]};
Physical Volume("disc", 1) = {parts[1]};
