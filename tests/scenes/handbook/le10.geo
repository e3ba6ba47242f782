// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The thick plate of NAFEMS LE10: the plan of LE1 (../../../meshes/le1.geo), -0.3 < z < 0.3 [m], in two parts along the ellipse with the half
// axes 2.625 and 1.875; curved tetrahedra of size h/f, smaller around (2, 0).
//
//     for part in 1 2; do gmsh -3 -order 2 -format msh41 -setnumber part $part le10.geo -o le10_$part.msh; done
//
// Boundary ids: 1 inner ellipse, 2 outer ellipse, 3 on the x axis, 4 on the y axis, 5 above, 6 below.
DefineConstant[ part = 1, f = 1 ];
a1 = part == 2 ? 2.625 : 2;
b1 = part == 2 ? 1.875 : 1;
a2 = part == 1 ? 2.625 : 3.25;
b2 = part == 1 ? 1.875 : 2.75;
h = (part == 2 ? 0.6 : 0.4)/f;
Point(1) = {0, 0, -0.3};
Point(2) = {a1, 0, -0.3, part == 2 ? h : 0.13/f};
Point(3) = {a2, 0, -0.3, h};
Point(4) = {0, b2, -0.3, h};
Point(5) = {0, b1, -0.3, h};
Line(1) = {2, 3};
Ellipse(2) = {3, 1, 3, 4};
Line(3) = {4, 5};
Ellipse(4) = {5, 1, 2, 2};
Line Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
volume[] = Extrude {0, 0, 0.6} { Surface{1}; Layers{(part == 1 ? 2 : 1)*f}; };
Physical Surface(1) = {volume[5]};
Physical Surface(2) = {volume[3]};
Physical Surface(3) = {volume[2]};
Physical Surface(4) = {volume[4]};
Physical Surface(5) = {volume[0]};
Physical Surface(6) = {1};
Physical Volume(0) = {volume[1]};
