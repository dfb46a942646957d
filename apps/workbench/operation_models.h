// Models of an operation: those that are touched, the background, and tools of hands.
#pragma once

#include "apps/workbench/operation.h"

namespace trephine::workbench {

/// Adds all background models as one structure, because a hand touches the picture that shows all of them.
/// The models need not be closed.
Status add_background(const OperationChoice& choice, sim::SceneDescription& spec, sim::SceneData& data,
                      const Listener& listener);
/// Adds the models of the case and of the choice, except background models.
Status add_models(const Source& source, const OperationChoice& choice, sim::SceneDescription& spec,
                  sim::SceneData& data, const Listener& listener);
/// Adds the models that are tools of hands.
Status add_tools(const OperationChoice& choice, const volume::Volume& anatomy, sim::SceneDescription& spec,
                 sim::SceneData& data, const Listener& listener);

}  // namespace trephine::workbench
