// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A ball of radius 1 of curved tetrahedra of second order: gmsh -3 curved_ball.geo
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 1};
Physical Surface(1) = {1};
Physical Volume(1) = {1};
Mesh.MeshSizeMin = 0.8;
Mesh.MeshSizeMax = 0.8;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 1;
Mesh.MshFileVersion = 4.1;
