// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One sector of a disk with the slot of the dovetail, all hexahedra. Lengths in millimetres; the scene scales by 1e-3.
//
//     z is the axis of rotation, y points outward through the middle of the slot; x = y = 0 is the axis.
//     The right half seen along z (the left half is its mirror image):
//
//                   C________E    rim
//                  /         |
//                 B----------G
//                  \         |    the flank: one circular arc from A to B
//                    A-------F
//            S_____-  \      |    bottom of the slot: an arc through S and A
//             |        K-----N    N: the sector's side
//             H------   \    |
//             |          \   |
//             |           |  |
//             D___________J__L    bore
//
// The same numbers A, B and flank_radius stand in blade.geo: both flanks are the same curved surface there.

// Joint (keep equal in blade.geo)
Ax = 12.0;  Ay = 135;          // foot of the right flank
Bx =  6.5;  By = 145;          // its upper end
flank_radius = 16;             // of the arc from A to B; its centre lies in the disk
thickness = 25;                // along the axis

// Disk
bore        = 60;              // radius
rim         = 150;             // radius
blades      = 20;              // a sector is one of these
slot_bottom = 127;             // at x = 0
mouth       = 9.2;             // half width of the slot's mouth, at C

// Where the blocks meet
Hy = 121;
Kx = 16;  Ky = 129.5;
side_N = 130.5;  side_F = 140.5;  side_G = 146.2;     // radii on the sector's side

// Cells
n_flank  = 5;                  // along a flank (blade: 7)
n_axial  = 7;                  // along the axis (blade: 11)
n_slot   = 5;                  // half the slot's bottom
n_lip    = 3;                  // between the slot and the side
n_ring   = 2;                  // around the slot's bottom, from S to H
n_mouth  = 2;
n_radial = 12;                 // from the slot to the bore

// ---------------------------------------------------------------------------------------------------------------------
half = Pi/blades;
z = -thickness/2;
chord    = Sqrt((Ax - Bx)^2 + (By - Ay)^2);
distance = Sqrt(flank_radius^2 - chord^2/4);          // of the arc's centre from its chord
centre_x = (Ax + Bx)/2 + distance*(By - Ay)/chord;
centre_y = (Ay + By)/2 + distance*(Ax - Bx)/chord;
sag      = Ay - slot_bottom;
bore_J   = half*n_slot/(n_slot + n_lip);              // angle of J

O  = newp;  Point(O) = {0, 0, z};
SO = newp;  Point(SO) = {0, slot_bottom + (Ax^2 + sag^2)/(2*sag), z};
S  = newp;  Point(S) = {0, slot_bottom, z};
H  = newp;  Point(H) = {0, Hy, z};
D  = newp;  Point(D) = {0, bore, z};
HS = newc;  Line(HS) = {H, S};
DH = newc;  Line(DH) = {D, H};
Transfinite Curve {HS} = n_ring + 1;
Transfinite Curve {DH} = n_radial + 1 Using Progression 1/1.06;

For side In {0:1}
  q = (side == 0) ? -1 : 1;    // left half, right half
  A = newp;  Point(A) = {q*Ax, Ay, z};
  B = newp;  Point(B) = {q*Bx, By, z};
  M = newp;  Point(M) = {q*centre_x, centre_y, z};
  C = newp;  Point(C) = {q*mouth, Sqrt(rim^2 - mouth^2), z};
  E = newp;  Point(E) = {q*rim*Sin(half), rim*Cos(half), z};
  G = newp;  Point(G) = {q*side_G*Sin(half), side_G*Cos(half), z};
  F = newp;  Point(F) = {q*side_F*Sin(half), side_F*Cos(half), z};
  N = newp;  Point(N) = {q*side_N*Sin(half), side_N*Cos(half), z};
  L = newp;  Point(L) = {q*bore*Sin(half), bore*Cos(half), z};
  J = newp;  Point(J) = {q*bore*Sin(bore_J), bore*Cos(bore_J), z};
  K = newp;  Point(K) = {q*Kx, Ky, z};

  AB = newc;  Circle(AB) = {A, M, B};
  SA = newc;  Circle(SA) = {S, SO, A};
  CE = newc;  Circle(CE) = {C, O, E};
  DJ = newc;  Circle(DJ) = {D, O, J};
  JL = newc;  Circle(JL) = {J, O, L};
  BC = newc;  Line(BC) = {B, C};
  BG = newc;  Line(BG) = {B, G};
  AF = newc;  Line(AF) = {A, F};
  KN = newc;  Line(KN) = {K, N};
  HK = newc;  Line(HK) = {H, K};
  KA = newc;  Line(KA) = {K, A};
  JK = newc;  Line(JK) = {J, K};
  LN = newc;  Line(LN) = {L, N};
  NF = newc;  Line(NF) = {N, F};
  FG = newc;  Line(FG) = {F, G};
  GE = newc;  Line(GE) = {G, E};

  Transfinite Curve {AB, FG}         = n_flank + 1;
  Transfinite Curve {SA, HK, DJ}     = n_slot + 1;
  Transfinite Curve {JL, KN, AF, BG, CE} = n_lip + 1;
  Transfinite Curve {KA, NF}         = n_ring + 1;
  Transfinite Curve {BC, GE}         = n_mouth + 1;
  Transfinite Curve {JK, LN}         = n_radial + 1 Using Progression 1/1.06;

  l = newll;
  Curve Loop(l)     = {DJ, JK, -HK, -DH};  Plane Surface(l)     = {l};      // hub, below the slot
  Curve Loop(l + 1) = {JL, LN, -KN, -JK};  Plane Surface(l + 1) = {l + 1};  // hub, beside it
  Curve Loop(l + 2) = {HK, KA, -SA, -HS};  Plane Surface(l + 2) = {l + 2};  // ring around the slot's bottom
  Curve Loop(l + 3) = {KN, NF, -AF, -KA};  Plane Surface(l + 3) = {l + 3};  // beside the ring
  Curve Loop(l + 4) = {AF, FG, -BG, -AB};  Plane Surface(l + 4) = {l + 4};  // lip, behind the flank
  Curve Loop(l + 5) = {BG, GE, -CE, -BC};  Plane Surface(l + 5) = {l + 5};  // mouth
  Transfinite Surface {l : l+5};
  Recombine Surface {l : l+5};
  front[] += {l : l+5};

  // Extrude answers with {opposite surface, volume, the surfaces over the loop's curves in their order}
  hub()    = Extrude {0, 0, thickness} { Surface{l};     Layers{n_axial}; Recombine; };
  beside() = Extrude {0, 0, thickness} { Surface{l + 1}; Layers{n_axial}; Recombine; };
  ring()   = Extrude {0, 0, thickness} { Surface{l + 2}; Layers{n_axial}; Recombine; };
  corner() = Extrude {0, 0, thickness} { Surface{l + 3}; Layers{n_axial}; Recombine; };
  lip()    = Extrude {0, 0, thickness} { Surface{l + 4}; Layers{n_axial}; Recombine; };
  top()    = Extrude {0, 0, thickness} { Surface{l + 5}; Layers{n_axial}; Recombine; };
  rear[]   += {hub(0), beside(0), ring(0), corner(0), lip(0), top(0)};
  bores[]  += {hub(2), beside(2)};
  free[]   += {ring(4), top(4), top(5)};
  flanks[] += {lip(5)};
  If (side == 0)
    left_side[]  = {beside(3), corner(3), lip(3), top(3)};
  Else
    right_side[] = {beside(3), corner(3), lip(3), top(3)};
  EndIf
EndFor

// Names: the boundary ids of the program
Physical Surface("left flank",  1) = {flanks(0)};
Physical Surface("right flank", 2) = {flanks(1)};
Physical Surface("bore",        3) = {bores()};
Physical Surface("left side",   4) = {left_side()};
Physical Surface("right side",  5) = {right_side()};
Physical Surface("front",       6) = {front()};
Physical Surface("rear",        7) = {rear()};
Physical Surface("rest",        8) = {free()};        // rim, mouth and bottom of the slot
Physical Volume("disk", 1) = {Volume{:}};
Mesh.MshFileVersion = 2.2;
