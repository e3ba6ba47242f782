// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#pragma once

namespace dovetail {

/// What this machine can still give before the kernel stops a process, in MiB: MemAvailable of /proc/meminfo,
/// less if the control group of the process (a batch system's, a container's) allows less. Infinite if
/// nothing is known.
double free_memory();

/// Gives to the machine what the process has freed between blocks that are in use: MPI libraries forbid the
/// allocator to place large blocks by themselves, so that it would not. Before much is allocated.
void give_back_freed_memory();

/// Gives the pages from @p begin to @p end to the machine, although they are freed later: what is there is
/// lost, and nobody reads it any more.
void give_back_pages(void *begin, void *end);

} // namespace dovetail
