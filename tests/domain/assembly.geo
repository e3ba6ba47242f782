// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two bars end to end, [0, 1] x [0, 1] x [0, 1] and [1, 2.5] x [0, 1] x [0, 1], with common nodes:
//   gmsh -3 -format msh41 assembly.geo -o assembly_41.msh
//   gmsh -3 -bin -format msh41 assembly.geo -o assembly_41_binary.msh
//   gmsh -3 -bin -format msh22 assembly.geo -o assembly_22_binary.msh
//   gmsh -3 -bin -order 2 -format msh41 assembly.geo -o assembly_41_order_2.msh
//   gmsh -3 -bin -order 2 -format msh22 -setnumber hexahedra 1 assembly.geo -o assembly_22_hexahedra.msh
//   gmsh -3 assembly.geo -o assembly_gmsh.inp
// The surface of "load" is in two physical groups where the format can say so (4.1).
DefineConstant[ hexahedra = 0 ];
Point(1) = {0, 0, 0};
line[] = Extrude {1, 0, 0} { Point{1}; Layers{1}; };
If (hexahedra)
  face[] = Extrude {0, 1, 0} { Curve{line[1]}; Layers{1}; Recombine; };
  first[] = Extrude {0, 0, 1} { Surface{face[1]}; Layers{1}; Recombine; };
  second[] = Extrude {1.5, 0, 0} { Surface{first[3]}; Layers{1}; Recombine; };
Else
  face[] = Extrude {0, 1, 0} { Curve{line[1]}; Layers{1}; };
  first[] = Extrude {0, 0, 1} { Surface{face[1]}; Layers{1}; };
  second[] = Extrude {1.5, 0, 0} { Surface{first[3]}; Layers{1}; };
EndIf
Physical Volume("bracket", 7) = {first[1]};
Physical Volume("plate", 8) = {second[1]};
Physical Surface("clamp", 1) = {first[5]};
Physical Surface("load", 2) = {second[0]};
Physical Surface("contact", 3) = {first[3]};
If (!hexahedra)
  Physical Surface("free end", 4) = {second[0], second[3]};
EndIf
