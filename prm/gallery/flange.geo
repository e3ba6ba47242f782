// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Half of a flanged joint, a body of revolution: weld-neck flange (steel) and half of the gasket. x: radius, y: axis. Lengths in mm.
// gmsh -2 -format msh41 flange.geo -o flange.msh
// flange: bore 50, pipe 58, hub 70, outer 110, thickness 20, hub to y = 50, pipe to y = 130
Point(1) = {50, 1, 0, 4};    Point(2) = {80, 1, 0, 3};    Point(3) = {80, 2, 0, 3};    Point(4) = {110, 2, 0, 5};
Point(5) = {110, 22, 0, 5};  Point(6) = {100, 22, 0, 4};  Point(7) = {84, 22, 0, 4};   Point(8) = {74, 22, 0, 2.5};
Point(9) = {70, 26, 0, 2.5}; Point(10) = {74, 26, 0, 3};  Point(11) = {58, 55, 0, 3};  Point(12) = {58, 130, 0, 4};
Point(13) = {50, 130, 0, 4}; Point(14) = {60, 1, 0, 3};
Line(1) = {1, 14}; Line(2) = {14, 2}; Line(3) = {2, 3}; Line(4) = {3, 4}; Line(5) = {4, 5}; Line(6) = {5, 6};
Line(7) = {6, 7}; Line(8) = {7, 8}; Circle(9) = {8, 10, 9}; Line(10) = {9, 11}; Line(11) = {11, 12}; Line(12) = {12, 13};
Line(13) = {13, 1};
Curve Loop(1) = {1:13}; Plane Surface(1) = {1};
// gasket: radius 60 to 80, half its thickness 1
Point(21) = {60, 0, 0, 0.8}; Point(22) = {80, 0, 0, 0.8}; Point(23) = {80, 1, 0, 0.8}; Point(24) = {60, 1, 0, 0.8};
Line(21) = {21, 22}; Line(22) = {22, 23}; Line(23) = {23, 24}; Line(24) = {24, 21};
Curve Loop(2) = {21:24}; Plane Surface(2) = {2};
Transfinite Curve{21, 23} = 33; Transfinite Curve{22, 24} = 3; Transfinite Surface{2};
Recombine Surface{2};
Physical Surface("flange") = {1}; Physical Surface("gasket") = {2};
Physical Curve("face") = {2}; Physical Curve("bolt") = {7}; Physical Curve("end") = {12}; Physical Curve("bore") = {13, 1};
Physical Curve("middle") = {21}; Physical Curve("gasket face") = {23}; Physical Curve("gasket bore") = {24};
