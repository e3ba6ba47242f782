// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A quarter of a strip, 10 by 18, around the circle of radius 7; curved triangles, smaller next to the circle.
//
//     gmsh -2 -order 2 -format msh41 strip.geo -o strip.msh
//
// Boundary ids: 1 the circle, 2 y = 0, 3 x = 10, 4 y = 18, 5 x = 0.
DefineConstant[ h = 1.2 ];
Point(1) = {0, 0, 0};
Point(2) = {7, 0, 0, h};
Point(3) = {10, 0, 0, h};
Point(4) = {10, 6, 0, h};
Point(5) = {10, 18, 0, 2.5*h};
Point(6) = {0, 18, 0, 2.5*h};
Point(7) = {0, 7, 0, h};
Line(1) = {2, 3};
Line(2) = {3, 4};
Line(3) = {4, 5};
Line(4) = {5, 6};
Line(5) = {6, 7};
Circle(6) = {7, 1, 2};
Curve Loop(1) = {1, 2, 3, 4, 5, 6};
Plane Surface(1) = {1};
Physical Curve(1) = {6};
Physical Curve(2) = {1};
Physical Curve(3) = {2, 3};
Physical Curve(4) = {4};
Physical Curve(5) = {5};
Physical Surface(0) = {1};
