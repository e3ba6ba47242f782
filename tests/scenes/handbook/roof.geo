// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A quarter of the Scordelis-Lo roof: a cylinder of radius 25 and thickness 0.25 from its crown (x = 0) to 40 degrees, 0 < y < 25; z is up.
// Part 1 reaches from the crown to 22 degrees, part 2 from there to the free edge. Hexahedra with plane faces.
//
//     for part in 1 2; do gmsh -3 -format msh22 -setnumber part $part roof.geo -o roof_$part.msh; done
//
// Boundary ids: 1 y = 0, 2 y = 25, 3 the smallest angle, 4 the largest, 5 inside and outside.
DefineConstant[ part = 1, f = 1 ];
around = f*(part == 1 ? 8 : 7);
along = f*(part == 1 ? 5 : 6);
a = (part == 1 ? 0 : 22)*Pi/180;
b = (part == 1 ? 22 : 40)*Pi/180;
Point(1) = {0, 0, 0};
Point(2) = {24.875*Sin(a), 0, 24.875*Cos(a)};
Point(3) = {25.125*Sin(a), 0, 25.125*Cos(a)};
Point(4) = {25.125*Sin(b), 0, 25.125*Cos(b)};
Point(5) = {24.875*Sin(b), 0, 24.875*Cos(b)};
Line(1) = {2, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 5};
Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 2;
Transfinite Curve {2, 4} = around + 1;
Transfinite Surface {1};
Recombine Surface {1};
volume[] = Extrude {0, 25, 0} { Surface{1}; Layers{along}; Recombine; };
Physical Surface(1) = {1};
Physical Surface(2) = {volume[0]};
Physical Surface(3) = {volume[2]};
Physical Surface(4) = {volume[4]};
Physical Surface(5) = {volume[3], volume[5]};
Physical Volume(0) = {volume[1]};
