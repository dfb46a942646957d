// Depth videos: conversion to touchable streams, and recording from models.
#pragma once

#include "apps/workbench/operation.h"
#include "data-tools/formats/depth_video.h"
#include "haptics/depth/depth_stream.h"

namespace trephine::workbench {

/// Converts a video to a touchable stream. The stream repeats if `is_repeating` is set or the video states a
/// period. If it states no period, the first picture follows the last one after the mean interval of the
/// pictures. A single picture does not repeat.
Result<std::shared_ptr<const haptics::depth::DepthStream>> stream_of(data_tools::DepthVideo video,
                                                                     bool is_repeating);

/// Returns the files of a model. If `model` is touched by its depth and is a folder, these are the keys of an
/// animation, sorted by name; otherwise its one file. Error if such a folder has no keys or more than 200.
Result<std::vector<std::string>> keys_of(const ModelChoice& model);

struct VideoRequest {
  glm::dvec3 from{0.0}, at{0.0};  ///< mm, positions of the camera and of its target
  int width = 320, height = 240;
  double angle = 40;   ///< degrees, horizontal field of view
  double rate = 30;    ///< pictures per second
  double seconds = 0;  ///< duration, s; 0: that of the models' longest motion
};
/// Records depth pictures of models with one ray per pixel, through its centre. Error if a model cannot be
/// loaded, the camera is at its target, the video would have more than 3000 pictures, or the listener
/// cancels.
Result<data_tools::DepthVideo> record_video(const std::vector<ModelChoice>& models,
                                            const VideoRequest& request, const Listener& listener);

}  // namespace trephine::workbench
