// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A tubular seal with two feet, in mm. gmsh -2 -format msh22 tube.geo -o tube.msh
n = 2;  // cells across the wall
m = 4;  // cells along half of a foot
k = 8;  // cells along a quarter of the tube, beside three at the foot
r = 6;  // outer and inner radius, middle, half width of a foot
q = 5;
h = 6.8;
f = 2.2;
s = r*Sin(35*Pi/180); // where the rounding of a foot meets the tube
c = h - r*Cos(35*Pi/180);
d = c - (s - f)*Tan(35*Pi/180);
Point(1) = {0, h, 0};
Point(2) = {-f, 0, 0};       Point(3) = {f, 0, 0};       Point(4) = {f, d, 0};        Point(5) = {s, c, 0};
Point(6) = {s, 2*h - c, 0};  Point(7) = {f, 2*h - d, 0}; Point(8) = {f, 2*h, 0};      Point(9) = {-f, 2*h, 0};
Point(10) = {-f, 2*h - d, 0}; Point(11) = {-s, 2*h - c, 0}; Point(12) = {-s, c, 0};   Point(13) = {-f, d, 0};
Point(14) = {r, h, 0};       Point(15) = {-r, h, 0};
For i In {0 : 1}
  x = q*Sin((27 + 13*i)*Pi/180);
  y = q*Cos((27 + 13*i)*Pi/180);
  Point(20 + i) = {x, h - y, 0};  Point(22 + i) = {x, h + y, 0};
  Point(24 + i) = {-x, h + y, 0}; Point(26 + i) = {-x, h - y, 0};
EndFor
Point(28) = {q, h, 0}; Point(29) = {-q, h, 0};
Line(1) = {2, 3};            Bezier(2) = {3, 4, 5};      Circle(3) = {5, 1, 14};      Circle(4) = {14, 1, 6};
Bezier(5) = {6, 7, 8};       Line(6) = {8, 9};           Bezier(7) = {9, 10, 11};     Circle(8) = {11, 1, 15};
Circle(9) = {15, 1, 12};     Bezier(10) = {12, 13, 2};
outer[] = {2, 3, 5, 14, 6, 8, 9, 11, 15, 12};
inner[] = {26, 20, 21, 28, 23, 22, 24, 25, 29, 27};
For i In {0 : 9}
  Circle(21 + i) = {inner[i], 1, inner[(i + 1) % 10]};
  Line(40 + i) = {outer[i], inner[i]};
EndFor
For i In {0 : 9}
  Curve Loop(i + 1) = {1 + i, 40 + (i + 1) % 10, -(21 + i), -(40 + i)};
  Plane Surface(i + 1) = {i + 1};
EndFor
Transfinite Curve{40 : 49} = n + 1;
Transfinite Curve{1, 6, 21, 26} = 2*m + 1;
Transfinite Curve{2, 5, 7, 10, 22, 25, 27, 30} = 4;
Transfinite Curve{3, 4, 8, 9, 23, 24, 28, 29} = k + 1;
Transfinite Surface{1 : 10};
Recombine Surface{1 : 10};
Physical Surface("seal") = {1 : 10};
Physical Curve("foot") = {1};
Physical Curve("head") = {6};
