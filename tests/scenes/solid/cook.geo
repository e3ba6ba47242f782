// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Cook's membrane cut in two from (19.2, 17.6) on its lower edge to (28.8, 53.6) on its upper one; 12 faces of the left
// part meet 8 of the right one. Boundary ids: 1 clamped, 2 loaded, 3 free, 4 the cut.
//
//     gmsh -2 -format msh22 -setnumber part 1 -o cook_left.msh  cook.geo
//     gmsh -2 -format msh22 -setnumber part 2 -o cook_right.msh cook.geo

DefineConstant[ part = 1 ];
Point(1) = {19.2, 17.6, 0};
Point(2) = {28.8, 53.6, 0};
Line(4) = {1, 2};
If (part == 1)
  Point(3) = {0, 44, 0};
  Point(4) = {0, 0, 0};
  n = 12;
  Physical Curve(1) = {6};
Else
  Point(3) = {48, 60, 0};
  Point(4) = {48, 44, 0};
  n = 8;
  Physical Curve(2) = {6};
EndIf
Line(5) = {2, 3};
Line(6) = {3, 4};
Line(7) = {4, 1};
Physical Curve(3) = {5, 7};
Physical Curve(4) = {4};
Curve Loop(1) = {4, 5, 6, 7};
Plane Surface(1) = {1};
Physical Surface(0) = {1};
Transfinite Curve {4, 6} = n + 1;
Transfinite Curve {5, 7} = (part == 1 ? 10 : 8) + 1;
Transfinite Surface {1};
Recombine Surface {1};
