// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/launcher.h>

#include <cstdlib>
#include <initializer_list>

namespace dovetail {

bool is_launched()
{
  for (const char *variable : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"})
    if (std::getenv(variable) != nullptr)
      return true;
  return false;
}

void skip_network_if_alone()
{
  if (is_launched())
    return;
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  setenv("OMPI_MCA_pml", "ob1", 1); // also in place of what suits several ranks (.ci/mpi_environment)
  setenv("OMPI_MCA_mpi_yield_when_idle", "0", 1); // likewise: there is no rank to let work
  setenv("OMPI_MCA_btl", "self", 0);
  setenv("OMPI_MCA_coll", "self,basic,libnbc", 0);
  // all such processes would share one directory, and one that ends removes it while another starts
  setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
  setenv("OMPI_MCA_sharedfp", "^sm", 0); // it would look for that directory
}

} // namespace dovetail
