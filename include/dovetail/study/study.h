// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Error against run time: `dovetail --study scene.prm`.

#pragma once

#include <string>
#include <vector>

namespace dovetail {

/// Run the scene over the levels, variants, ranks and repeats of its `subsection Study`, each in a process of
/// its own, and write study.csv, study.txt, study.svg and study.png into its `Directory`. Runs that are there
/// from before are not done again. MPI must not be initialized; of several processes that mpirun started only
/// the first works, and their number is the default of `Ranks`.
/// @return whether some run converged. @throw UserError
bool run_study(const std::string &scene, const std::vector<std::string> &overrides);

/// Whether this process is the one that works, of those that mpirun started together.
bool is_first_of_launched();

} // namespace dovetail
