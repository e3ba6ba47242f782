// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The half section of NAFEMS LE11: x is the radius, y the axis [m]. Part 1 is the sphere between the radii 1 and 1.4 below
// y = sqrt(1/2), part 2 the taper, part 3 the cylinder; curved triangles, f times as many along each line.
//
//     for part in 1 2 3; do gmsh -2 -order 2 -format msh41 -setnumber part $part le11.geo -o le11_$part.msh; done
//
// Boundary ids: 1 inside, 2 outside, 3 below, 4 above.
DefineConstant[ part = 1, f = 2 ];
c = Sqrt(0.5);
If (part == 1)
  Point(1) = {1, 0, 0};
  Point(2) = {1.4, 0, 0};
  Point(3) = {Sqrt(1.96 - 0.5), c, 0};
  Point(4) = {c, c, 0};
  Point(5) = {0, 0, 0};
  Circle(2) = {2, 5, 3};
  Circle(4) = {4, 5, 1};
  across = 4; along = 6;
ElseIf (part == 2)
  Point(1) = {c, c, 0};
  Point(2) = {Sqrt(1.96 - 0.5), c, 0};
  Point(3) = {1, c + 0.69, 0};
  Point(4) = {c, c + 0.69, 0};
  Line(2) = {2, 3};
  Line(4) = {4, 1};
  across = 3; along = 5;
Else
  Point(1) = {c, c + 0.69, 0};
  Point(2) = {1, c + 0.69, 0};
  Point(3) = {1, c + 1.09, 0};
  Point(4) = {c, c + 1.09, 0};
  Line(2) = {2, 3};
  Line(4) = {4, 1};
  across = 4; along = 4;
EndIf
Line(1) = {1, 2};
Line(3) = {3, 4};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = f*across + 1;
Transfinite Curve {2, 4} = f*along + 1;
Physical Curve(1) = {4};
Physical Curve(2) = {2};
Physical Curve(3) = {1};
Physical Curve(4) = {3};
Physical Surface(0) = {1};
