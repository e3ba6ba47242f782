// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A turbine blade with a dovetail root, all hexahedra. Lengths in millimetres; the scene scales by 1e-3.
//
//     z is the axis of rotation, y points outward along the blade, x around the disk; x = y = 0 is the axis.
//     Seen along z, the blade is one column of blocks (root, neck, platform, airfoil) with a wing on either side:
//
//        level 4   y = 227           ||          tip
//                                    ||          airfoil, cambered, tapered and twisted
//        level 3   y = 157     ______||______
//        level 2   y = 151    |_____    _____|   platform
//        level 1   y = 145          |  |         neck;  B = where a flank ends, outside
//        level 0   y = 135         /____\        root;  A = where a flank begins, inside. Each flank is one circular arc
//
// The same numbers A, B and flank_radius stand in disk.geo: both flanks are the same curved surface there.

// Joint (keep equal in disk.geo)
Ax = 12.0;  Ay = 135;          // foot of the right flank
Bx =  6.5;  By = 145;          // its upper end
flank_radius = 16;             // of the arc from A to B; its centre lies in the disk
thickness = 25;                // along the axis

// Blade
root_bottom    = 131.5;        // at x = 0; the slot is deeper, root and slot do not touch there
neck_top       = 151;
platform_top   = 157;
platform_half  = 20;
tip            = 227;
margin         = 1.5;          // between the airfoil and the platform's front and rear edge

// Sections of the airfoil, at its root and at its tip: x of the camber line and z, and half the thickness along x
root_lead_x = -1.0;  root_lead_z = -thickness/2 + margin;  root_tail_x = -1.5;  root_tail_z = thickness/2 - margin;
tip_lead_x  = -3.0;  tip_lead_z  = -8;                     tip_tail_x  =  2.5;  tip_tail_z  = 8;
root_camber = 2.4;   root_lead_half = 1.4;  root_tail_half = 1.2;  root_bump = 2.2;
tip_camber  = 0.8;   tip_lead_half  = 1.0;  tip_tail_half  = 0.8;  tip_bump  = 1.0;

// Cells
n_across   = 6;                // through the root, and through the airfoil
n_flank    = 7;                // along a flank (disk: 5)
n_neck     = 3;
n_platform = 3;
n_wing     = 5;
n_height   = 18;               // along the airfoil
n_chord    = 9;                // along the chord; with one cell in either margin 11 along the axis (disk: 7)

// ---------------------------------------------------------------------------------------------------------------------
// Points: tag = 100 i + 10 j + k, i = 0 … 3 across (x), j = 0 … 4 outward (y), k = 0 … 3 along the axis (z)
z() = {-thickness/2, -thickness/2 + margin, thickness/2 - margin, thickness/2};
y() = {Ay, By, neck_top, platform_top};
x() = {Ax, Bx, Bx};            // half width of the middle column at levels 0 … 2
edge_half = 2.4;               // and at level 3, at the platform's front and rear edge
For k In {0:3}
  For j In {0:2}
    Point(100 + 10*j + k) = {-x(j), y(j), z(k)};
    Point(200 + 10*j + k) = { x(j), y(j), z(k)};
  EndFor
  For j In {2:3}
    Point(      10*j + k) = {-platform_half, y(j), z(k)};
    Point(300 + 10*j + k) = { platform_half, y(j), z(k)};
  EndFor
EndFor
For k In {0:3:3}
  Point(130 + k) = {(k == 0 ? root_lead_x : root_tail_x) - edge_half, platform_top, z(k)};
  Point(230 + k) = {(k == 0 ? root_lead_x : root_tail_x) + edge_half, platform_top, z(k)};
EndFor
Point(131) = {root_lead_x - root_lead_half, platform_top, root_lead_z};
Point(231) = {root_lead_x + root_lead_half, platform_top, root_lead_z};
Point(132) = {root_tail_x - root_tail_half, platform_top, root_tail_z};
Point(232) = {root_tail_x + root_tail_half, platform_top, root_tail_z};
Point(141) = {tip_lead_x - tip_lead_half, tip, tip_lead_z};
Point(241) = {tip_lead_x + tip_lead_half, tip, tip_lead_z};
Point(142) = {tip_tail_x - tip_tail_half, tip, tip_tail_z};
Point(242) = {tip_tail_x + tip_tail_half, tip, tip_tail_z};

// Curves: 1000 + tag of the first point along x, 2000 + … along y, 3000 + … along z.
// The arcs: flanks and bottom of the root
chord    = Sqrt((Ax - Bx)^2 + (By - Ay)^2);
distance = Sqrt(flank_radius^2 - chord^2/4);                        // of the centre from the chord
centre_x = (Ax + Bx)/2 + distance*(By - Ay)/chord;
centre_y = (Ay + By)/2 + distance*(Ax - Bx)/chord;
sag      = Ay - root_bottom;
For k In {0:3}
  c = newp;  Point(c)     = {-centre_x, centre_y, z(k)};
             Point(c + 1) = { centre_x, centre_y, z(k)};
             Point(c + 2) = {0, root_bottom + (Ax^2 + sag^2)/(2*sag), z(k)};
  Circle(2100 + k) = {100 + k, c,     110 + k};
  Circle(2200 + k) = {200 + k, c + 1, 210 + k};
  Circle(1100 + k) = {100 + k, c + 2, 200 + k};
  For j In {1:2}
    Line(1100 + 10*j + k) = {100 + 10*j + k, 200 + 10*j + k};
    Line(2100 + 10*j + k) = {100 + 10*j + k, 110 + 10*j + k};
    Line(2200 + 10*j + k) = {200 + 10*j + k, 210 + 10*j + k};
  EndFor
  For j In {2:3}
    Line(1000 + 10*j + k) = {      10*j + k, 100 + 10*j + k};
    Line(1200 + 10*j + k) = {200 + 10*j + k, 300 + 10*j + k};
  EndFor
  Line(2020 + k) = { 20 + k,  30 + k};
  Line(2320 + k) = {320 + k, 330 + k};
EndFor
Line(1130) = {130, 230};
Line(1133) = {133, 233};
For k In {0:2}
  For j In {0:2}
    Line(3100 + 10*j + k) = {100 + 10*j + k, 101 + 10*j + k};
    Line(3200 + 10*j + k) = {200 + 10*j + k, 201 + 10*j + k};
  EndFor
  For j In {2:3}
    Line(3000 + 10*j + k) = {      10*j + k,   1 + 10*j + k};
    Line(3300 + 10*j + k) = {300 + 10*j + k, 301 + 10*j + k};
  EndFor
EndFor
For k In {0:2:2}
  Line(3130 + k) = {130 + k, 131 + k};
  Line(3230 + k) = {230 + k, 231 + k};
EndFor
Line(2131) = {131, 141};  Line(2132) = {132, 142};                  // leading and trailing edges
Line(2231) = {231, 241};  Line(2232) = {232, 242};

// The airfoil's outlines: splines along pressure and suction side, rounded at the edges
For j In {3:4}
  If (j == 3)
    lx = root_lead_x; lz = root_lead_z; tx = root_tail_x; tz = root_tail_z; h = platform_top;
    camber = root_camber; lh = root_lead_half; th = root_tail_half; bump = root_bump;
  Else
    lx = tip_lead_x; lz = tip_lead_z; tx = tip_tail_x; tz = tip_tail_z; h = tip;
    camber = tip_camber; lh = tip_lead_half; th = tip_tail_half; bump = tip_bump;
  EndIf
  c = newp;
  For q In {1:7}
    s = q/8;
    middle = lx*(1 - s) + tx*s + 4*camber*s*(1 - s);
    half   = lh*(1 - s) + th*s + 6.75*bump*s*(1 - s)^2;             // thickest at a third of the chord
    Point(c + q - 1)  = {middle - half, h, lz*(1 - s) + tz*s};
    Point(c + q + 9) = {middle + half, h, lz*(1 - s) + tz*s};
  EndFor
  Point(c + 20) = {lx, h, lz - 0.25*lh};
  Point(c + 21) = {tx, h, tz + 0.25*th};
  Spline(3101 + 10*j) = {101 + 10*j, c:c+6,     102 + 10*j};
  Spline(3201 + 10*j) = {201 + 10*j, c+10:c+16, 202 + 10*j};
  Spline(1101 + 10*j) = {101 + 10*j, c + 20, 201 + 10*j};
  Spline(1102 + 10*j) = {102 + 10*j, c + 21, 202 + 10*j};
EndFor

// Surfaces: 10000 + tag of the first point, across x and y; 20000 + … across x and z; 30000 + … across y and z
Macro AcrossXY   // at i, j, k
  p = 100*i + 10*j + k;
  Curve Loop(10000 + p) = {1000 + p, 2100 + p, -(1010 + p), -(2000 + p)};
  Surface(10000 + p) = {10000 + p};
Return
Macro AcrossXZ
  p = 100*i + 10*j + k;
  Curve Loop(20000 + p) = {1000 + p, 3100 + p, -(1001 + p), -(3000 + p)};
  Surface(20000 + p) = {20000 + p};
Return
Macro AcrossYZ
  p = 100*i + 10*j + k;
  Curve Loop(30000 + p) = {2000 + p, 3010 + p, -(2001 + p), -(3000 + p)};
  Surface(30000 + p) = {30000 + p};
Return
Macro Body
  p = 100*i + 10*j + k;
  Surface Loop(p + 1) = {10000 + p, 10001 + p, 20000 + p, 20010 + p, 30000 + p, 30100 + p};
  Volume(p + 1) = {p + 1};
Return

For k In {0:3}
  i = 1;
  For j In {0:2}
    Call AcrossXY;
  EndFor
  j = 2;
  For i In {0:2:2}
    Call AcrossXY;
  EndFor
EndFor
i = 1;  j = 3;
For k In {1:2}
  Call AcrossXY;
EndFor
For k In {0:2}
  i = 1;
  For j In {0:3}
    Call AcrossXZ;
  EndFor
  For i In {0:2:2}
    For j In {2:3}
      Call AcrossXZ;
    EndFor
  EndFor
  For i In {1:2}
    For j In {0:2}
      Call AcrossYZ;
    EndFor
  EndFor
  j = 2;
  For i In {0:3:3}
    Call AcrossYZ;
  EndFor
EndFor
i = 1;  j = 4;  k = 1;  Call AcrossXZ;
j = 3;
For i In {1:2}
  Call AcrossYZ;
EndFor
For k In {0:2}
  i = 1;
  For j In {0:2}
    Call Body;
  EndFor
  j = 2;
  For i In {0:2:2}
    Call Body;
  EndFor
EndFor
i = 1;  j = 3;  k = 1;  Call Body;

// Cells
For k In {0:3}
  For j In {0:3}
    Transfinite Curve {1100 + 10*j + k} = n_across + 1;
  EndFor
  For j In {2:3}
    Transfinite Curve {1000 + 10*j + k, 1200 + 10*j + k} = n_wing + 1;
  EndFor
  Transfinite Curve {2100 + k, 2200 + k} = n_flank + 1;
  Transfinite Curve {2110 + k, 2210 + k} = n_neck + 1;
  Transfinite Curve {2020 + k, 2120 + k, 2220 + k, 2320 + k} = n_platform + 1;
EndFor
Transfinite Curve {1141, 1142} = n_across + 1;
Transfinite Curve {2131, 2132, 2231, 2232} = n_height + 1;
For k In {0:2}
  n = (k == 1) ? n_chord : 1;
  For j In {0:3}
    Transfinite Curve {3100 + 10*j + k, 3200 + 10*j + k} = n + 1;
  EndFor
  For j In {2:3}
    Transfinite Curve {3000 + 10*j + k, 3300 + 10*j + k} = n + 1;
  EndFor
EndFor
Transfinite Curve {3141, 3241} = n_chord + 1;
Transfinite Surface "*";
Recombine Surface "*";
Transfinite Volume "*";

// Names: the boundary ids of the program
Physical Surface("left flank",  1) = {30100:30102};
Physical Surface("right flank", 2) = {30200:30202};
Physical Surface("airfoil",     3) = {30131, 30231, 10131, 10132, 20141};
Physical Surface("platform",    4) = {20030:20032, 20230:20232, 20130, 20132};
Physical Surface("rest",        5) = {20100:20102, 30110:30112, 30210:30212,         // bottom and neck
                                      20020:20022, 20220:20222, 30020:30022, 30320:30322,  // platform below and beside
                                      10100, 10110, 10120, 10020, 10220,             // front
                                      10103, 10113, 10123, 10023, 10223};            // rear
Physical Volume("blade", 1) = {Volume{:}};
Mesh.MshFileVersion = 4.1;
