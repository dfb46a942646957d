// Depth videos, as things to touch, and made of models.
#pragma once

#include "apps/workbench/operation.h"
#include "data-tools/depth_video.h"
#include "haptics/depth/depth_stream.h"

namespace trephine::workbench {

/// To be touched. `is_repeating`: after its last picture comes the first, a beat later, unless the video says
/// when.
volume::Result<std::shared_ptr<const haptics::depth::DepthStream>> stream_of(data_tools::DepthVideo video,
                                                                             bool is_repeating);

/// The files of a model: of a folder all of its models, by their names.
volume::Result<std::vector<std::string>> keys_of(const ModelChoice& model);

struct VideoRequest {
  glm::dvec3 from{0.0}, at{0.0};  ///< mm, of the camera, and what it looks at
  int width = 320, height = 240;
  double angle = 40;   ///< degrees, of the width
  double rate = 30;    ///< pictures a second
  double seconds = 0;  ///< 0: as long as the models move
};
/// Depth picture of models by a camera: a ray a pixel, through its middle.
volume::Result<data_tools::DepthVideo> record_video(const std::vector<ModelChoice>& models,
                                                    const VideoRequest& request, const Listener& listener);

}  // namespace trephine::workbench
