// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#pragma once

namespace dovetail {

/// Whether mpirun, srun or the like has started this process; MPI need not be initialized.
bool is_launched();

/// A process that mpirun did not start is alone: Open MPI need not look for networks or start a daemon, which
/// would take it 0.3 s. What the environment says already stays, but for how ranks send messages and wait.
void skip_network_if_alone();

} // namespace dovetail
