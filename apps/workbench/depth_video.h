// Depth videos: conversion to touchable streams, and recording from models.
#pragma once

#include "apps/workbench/operation.h"
#include "data-tools/formats/depth_video.h"
#include "haptics/depth/depth_stream.h"

namespace trephine::workbench {

/// Converts a video to a touchable stream. `is_repeating`: the first picture follows the last, after the mean
/// interval of the pictures unless the video states another.
Result<std::shared_ptr<const haptics::depth::DepthStream>> stream_of(data_tools::DepthVideo video,
                                                                     bool is_repeating);

/// Returns the files of a model, sorted by name: those of its animation if it is a folder.
Result<std::vector<std::string>> keys_of(const ModelChoice& model);

struct VideoRequest {
  glm::dvec3 from{0.0}, at{0.0};  ///< mm, positions of the camera and of its target
  int width = 320, height = 240;
  double angle = 40;   ///< degrees, horizontal field of view
  double rate = 30;    ///< pictures per second
  double seconds = 0;  ///< duration; 0: that of the models' motion
};
/// Records depth pictures of models by a camera: one ray per pixel, through its centre.
Result<data_tools::DepthVideo> record_video(const std::vector<ModelChoice>& models,
                                            const VideoRequest& request, const Listener& listener);

}  // namespace trephine::workbench
