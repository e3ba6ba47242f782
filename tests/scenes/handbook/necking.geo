// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A quarter of the round bar of Simo (1988): radius 6.413, at the neck 0.982 times that, half of the length 53.334. Part 1 reaches
// from the neck to y = 8.
//
//     for part in 1 2; do gmsh -2 -format msh22 -setnumber part $part necking.geo -o necking_$part.msh; done
//
// Boundary ids: 1 below, 2 outside, 3 above, 4 the axis.
DefineConstant[ part = 1, f = 1 ];
R = 6.413;
L = 26.667;
below = part == 1 ? 0 : 8;
above = part == 1 ? 8 : L;
Point(1) = {0, below, 0};
Point(2) = {R*(0.982 + 0.018*below/L), below, 0};
Point(3) = {R*(0.982 + 0.018*above/L), above, 0};
Point(4) = {0, above, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = f*(part == 1 ? 4 : 3) + 1;
Transfinite Curve {2} = f*(part == 1 ? 8 : 6) + 1 Using Progression (part == 1 ? 1 : 1.2^(1/f));
Transfinite Curve {4} = f*(part == 1 ? 8 : 6) + 1 Using Progression (part == 1 ? 1 : 1/1.2^(1/f));
Transfinite Surface {1};
Recombine Surface {1};
Physical Curve(1) = {1};
Physical Curve(2) = {2};
Physical Curve(3) = {3};
Physical Curve(4) = {4};
Physical Surface(0) = {1};
