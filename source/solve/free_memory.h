// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#pragma once

namespace dovetail {

/// What this machine can still give before the kernel stops a process, in MiB: MemAvailable of /proc/meminfo,
/// less if the control group of the process (a batch system's, a container's) allows less. Infinite if
/// nothing is known.
double free_memory();

} // namespace dovetail
