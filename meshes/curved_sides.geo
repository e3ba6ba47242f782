// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two blocks with curved sides, of quadrilaterals or hexahedra of second order, that meet at the flat seam x = 1:
//   gmsh -2 curved_sides.geo -setnumber incomplete 1 -o curved_sides_left_2d.inp
//   gmsh -2 curved_sides.geo -setnumber right 1 -o curved_sides_right_2d.msh
//   gmsh -3 curved_sides.geo -setnumber height 1 -o curved_sides_left_3d.msh
//   gmsh -3 curved_sides.geo -setnumber height 1 -setnumber right 1 -setnumber incomplete 1 -o curved_sides_right_3d.inp
DefineConstant[right = 0, height = 0, incomplete = 0];
far = right ? 2 : 0;
n = right ? 3 : 2;
Point(1) = {1, 0, 0};
Point(2) = {1, 1, 0};
Point(3) = {far, 1, 0};
Point(4) = {far, 0, 0};
Point(5) = {0.5 + right, -0.15, 0};
Point(6) = {0.5 + right, 1.2, 0};
Point(7) = {far + (right ? 0.2 : -0.1), 0.5, 0};
Line(1) = {1, 2};
Spline(2) = {2, 6, 3};
Spline(3) = {3, 7, 4};
Spline(4) = {4, 5, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = n + 1;
Transfinite Curve{2, 4} = 3;
Transfinite Surface{1};
Recombine Surface{1};
If (height > 0)
  box[] = Extrude {0, 0, height} { Surface{1}; Layers{n + 1}; Recombine; };
  Physical Volume("block") = {box[1]};
  Physical Surface("seam") = {box[2]};
  Physical Surface("rim") = {1, box[0], box[3], box[4], box[5]};
Else
  Physical Surface("block") = {1};
  Physical Curve("seam") = {1};
  Physical Curve("rim") = {2, 3, 4};
EndIf
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = incomplete;
