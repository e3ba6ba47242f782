// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A disk of radius 1 of curved triangles of second order: gmsh -2 curved_disk.geo, and with -setnumber size 0.35 -o curved_disk_finer.msh
SetFactory("OpenCASCADE");
Disk(1) = {0, 0, 0, 1};
Physical Curve(1) = {1};
Physical Surface(1) = {1};
DefineConstant[size = 0.7];
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
Mesh.ElementOrder = 2;
Mesh.MshFileVersion = 4.1;
