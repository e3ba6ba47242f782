// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A quarter of a ring of the radii r0 and r1. Gmsh 4.8.4:
//   gmsh sector.geo -3 -order 2 -setnumber r0 1.35 -setnumber r1 1.5 -setnumber lc 0.15 -o sector_inner.msh
//   gmsh sector.geo -3 -order 2 -setnumber r0 1.5 -setnumber r1 1.9 -setnumber lc 0.45 -o sector_outer.msh
DefineConstant[ r0=1, r1=1.5, lc=0.15, H=0.2 ];
Point(1)={0,0,0,lc}; Point(2)={r0,0,0,lc}; Point(3)={r1,0,0,lc}; Point(4)={0,r1,0,lc}; Point(5)={0,r0,0,lc};
Line(1)={2,3}; Circle(2)={3,1,4}; Line(3)={4,5}; Circle(4)={5,1,2};
Curve Loop(1)={1,2,3,4}; Plane Surface(1)={1};
e[] = Extrude{0,0,H}{ Surface{1}; };
Physical Volume("ring")={e[1]};
Physical Surface("bottom")={1}; Physical Surface("top")={e[0]};
Physical Surface("y plane")={e[2]}; Physical Surface("outer")={e[3]}; Physical Surface("x plane")={e[4]}; Physical Surface("inner")={e[5]};
