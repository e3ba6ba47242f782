// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A quarter of a heat sink with seven fins (half of the one in the middle, and three more) and of the chip below it, of hexahedra.
// Lengths in mm. gmsh -3 -format msh41 -bin heat_sink.geo -o heat_sink.msh
// profile: base 22 x 5, fins 2 thick and 30 high, one each 7 mm; extruded by 25
x[] = {0, 1, 6, 8, 13, 15, 20, 22};
n[] = {1, 3, 2, 3, 2, 3, 2};       // cells between two of them
For i In {0:7}
  Point(1 + i) = {x[i], 1, 0}; Point(11 + i) = {x[i], 6, 0};
  Line(21 + i) = {1 + i, 11 + i}; Transfinite Curve{21 + i} = 3;
EndFor
base[] = {}; fins[] = {};
For i In {0:6}
  Line(31 + i) = {1 + i, 2 + i}; Line(41 + i) = {11 + i, 12 + i};
  Transfinite Curve{31 + i, 41 + i} = n[i] + 1;
  Curve Loop(1 + i) = {31 + i, 22 + i, -(41 + i), -(21 + i)};
  Plane Surface(1 + i) = {1 + i}; Transfinite Surface{1 + i}; Recombine Surface{1 + i};
  base[] += {1 + i};
EndFor
For i In {0:6:2}
  f[] = Extrude{0, 30, 0} { Curve{41 + i}; Layers{10}; Recombine; };
  fins[] += {f[1]};
EndFor
v[] = Extrude{0, 0, 25} { Surface{base[], fins[]}; Layers{8}; Recombine; };
sink[] = Volume{:};

// chip 7.5 x 1 x 7.5 below
Point(901) = {0, 0, 0}; Point(902) = {7.5, 0, 0}; Point(903) = {7.5, 1, 0}; Point(904) = {0, 1, 0};
For i In {0:3}
  Line(901 + i) = {901 + i, 901 + (i + 1)%4};
EndFor
Transfinite Curve{901, 903} = 6; Transfinite Curve{902, 904} = 3;
Curve Loop(901) = {901:904}; Plane Surface(901) = {901}; Transfinite Surface{901}; Recombine Surface{901};
c[] = Extrude{0, 0, 7.5} { Surface{901}; Layers{5}; Recombine; };

e = 0.01;
Physical Volume("sink") = {sink[]};
Physical Volume("chip") = {c[1]};
Physical Surface("x plane") = Surface In BoundingBox{-e, 1 - e, -e, e, 36 + e, 25 + e};
Physical Surface("z plane") = Surface In BoundingBox{-e, 1 - e, -e, 22 + e, 36 + e, e};
Physical Surface("underside") = Surface In BoundingBox{-e, 1 - e, -e, 22 + e, 1 + e, 25 + e};
Physical Surface("chip top") = {c[4]};
Physical Surface("chip bottom") = {c[2]};
