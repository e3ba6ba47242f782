// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The elliptic membrane of NAFEMS LE1, a quarter between (x/2)^2 + y^2 = 1 and (x/3.25)^2 + (y/2.75)^2 = 1 [m], in two parts along the ellipse with
// the half axes 2.625 and 1.875, or whole; curved triangles.
//
//     gmsh -2 -order 2 -format msh41 -setnumber part 1 le1.geo -o le1_inner.msh
//     gmsh -2 -order 2 -format msh41 -setnumber part 2 le1.geo -o le1_outer.msh
//     gmsh -2 -order 2 -format msh41 -setnumber part 0 le1.geo -o le1_whole.msh
//
// Boundary ids: 1 inner ellipse, 2 outer ellipse, 3 on the x axis, 4 on the y axis.
DefineConstant[ part = 1 ];
a1 = part == 2 ? 2.625 : 2;
b1 = part == 2 ? 1.875 : 1;
a2 = part == 1 ? 2.625 : 3.25;
b2 = part == 1 ? 1.875 : 2.75;
h = part == 2 ? 0.33 : 0.25;
Point(1) = {0, 0, 0};
Point(2) = {a1, 0, 0, part == 2 ? h : 0.03};
Point(3) = {a2, 0, 0, h};
Point(4) = {0, b2, 0, h};
Point(5) = {0, b1, 0, h};
Line(1) = {2, 3};
Ellipse(2) = {3, 1, 3, 4};
Line(3) = {4, 5};
Ellipse(4) = {5, 1, 2, 2};
Line Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Line(3) = {1};
Physical Line(2) = {2};
Physical Line(4) = {3};
Physical Line(1) = {4};
Physical Surface(1) = {1};
