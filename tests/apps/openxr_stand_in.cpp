// A stand-in for the OpenXR loader and a runtime with a headset, written from the specification OpenXR 1.0:
// it checks the order of the calls and keeps the pictures. Eyes are 64 mm apart, with asymmetric fields of
// view; the display has 320 x 240 pixels per eye.
#include "tests/apps/openxr_stand_in.h"

#include <GL/glx.h>
#include <cmath>
#include <cstring>
#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

using trephine::view::stand_in::Log;

namespace {

Log g_log;

constexpr int k_width = 320, k_height = 240, k_images = 3;
template <class Handle>
Handle handle(std::uintptr_t number) {
  return reinterpret_cast<Handle>(number);
}

struct Swapchain {
  std::array<GLuint, k_images> textures{};
  int next = 0, acquired = -1;
  bool is_waited = false, is_released = false;
} g_swapchains[2];
int g_swapchain_count = 0;
bool g_is_running = false, g_has_waited = false, g_has_begun = false, g_has_requirements = false;
int g_events = 0;

void expect(bool is_right, const char* mistake) {
  if (!is_right) g_log.mistakes.emplace_back(mistake);
}

XrPosef pose_of_eye(int eye) {
  const double side = eye == 0 ? -0.032 : 0.032;
  XrPosef pose{};
  pose.orientation.y = static_cast<float>(std::sin(0.5 * g_log.yaw));
  pose.orientation.w = static_cast<float>(std::cos(0.5 * g_log.yaw));
  pose.position = {static_cast<float>(g_log.head[0] + side * std::cos(g_log.yaw)),
                   static_cast<float>(g_log.head[1]),
                   static_cast<float>(g_log.head[2] - side * std::sin(g_log.yaw))};
  return pose;
}

XrFovf fov_of_eye(int eye) {
  return eye == 0 ? XrFovf{-0.5f, 0.4f, 0.45f, -0.4f} : XrFovf{-0.4f, 0.5f, 0.45f, -0.4f};
}

XrResult create_instance(const XrInstanceCreateInfo* info, XrInstance* instance) {
  expect(info->type == XR_TYPE_INSTANCE_CREATE_INFO, "instance info without type");
  bool wants_opengl = false;
  for (std::uint32_t i = 0; i < info->enabledExtensionCount; ++i)
    wants_opengl |= std::strcmp(info->enabledExtensionNames[i], XR_KHR_OPENGL_ENABLE_EXTENSION_NAME) == 0;
  expect(wants_opengl, "instance without the OpenGL extension");
  expect(info->applicationInfo.applicationName[0] != 0, "application without a name");
  if (!g_log.has_opengl) return XR_ERROR_EXTENSION_NOT_PRESENT;
  ++g_log.instances;
  *instance = handle<XrInstance>(1);
  return XR_SUCCESS;
}
XrResult destroy_instance(XrInstance) {
  expect(g_log.sessions == 0, "instance destroyed before its session");
  --g_log.instances;
  return XR_SUCCESS;
}
XrResult get_system(XrInstance, const XrSystemGetInfo* info, XrSystemId* system) {
  expect(info->formFactor == XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY, "another form factor");
  *system = 7;
  return g_log.has_display ? XR_SUCCESS : XR_ERROR_FORM_FACTOR_UNAVAILABLE;
}
XrResult get_requirements(XrInstance, XrSystemId, XrGraphicsRequirementsOpenGLKHR* requirements) {
  expect(requirements->type == XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR, "requirements without type");
  g_has_requirements = true;
  return XR_SUCCESS;
}
XrResult create_session(XrInstance, const XrSessionCreateInfo* info, XrSession* session) {
  const auto* binding = static_cast<const XrGraphicsBindingOpenGLXlibKHR*>(info->next);
  expect(g_has_requirements, "session before the requirements were asked");
  expect(binding != nullptr && binding->type == XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR,
         "session without a graphics binding");
  expect(binding->xDisplay == glXGetCurrentDisplay() && binding->glxContext == glXGetCurrentContext() &&
             binding->glxContext != nullptr && binding->glxFBConfig != nullptr && binding->visualid != 0,
         "the binding is not the current context");
  ++g_log.sessions;
  g_events = 0;
  *session = handle<XrSession>(2);
  return XR_SUCCESS;
}
XrResult destroy_session(XrSession) {
  expect(!g_has_begun, "session destroyed within a frame");
  --g_log.sessions;
  g_is_running = g_has_waited = g_has_begun = g_has_requirements = false;
  g_swapchain_count = 0;
  return XR_SUCCESS;
}
XrResult create_space(XrSession, const XrReferenceSpaceCreateInfo* info, XrSpace* space) {
  const XrQuaternionf& q = info->poseInReferenceSpace.orientation;
  expect(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-6, "space without a unit pose");
  *space = handle<XrSpace>(3);
  return XR_SUCCESS;
}
XrResult get_views(XrInstance, XrSystemId, XrViewConfigurationType type, std::uint32_t capacity,
                   std::uint32_t* count, XrViewConfigurationView* views) {
  expect(type == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, "another view configuration");
  *count = 2;
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < 2) return XR_ERROR_SIZE_INSUFFICIENT;
  for (int i = 0; i < 2; ++i)
    views[i].recommendedImageRectWidth = k_width, views[i].recommendedImageRectHeight = k_height;
  return XR_SUCCESS;
}
XrResult get_formats(XrSession, std::uint32_t capacity, std::uint32_t* count, std::int64_t* formats) {
  *count = 2;
  if (capacity >= 2) formats[0] = GL_RGBA16F, formats[1] = GL_SRGB8_ALPHA8;
  return XR_SUCCESS;
}
XrResult create_swapchain(XrSession, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain) {
  expect(info->format == GL_SRGB8_ALPHA8, "a format that was not offered");
  expect(info->sampleCount == 1 && info->faceCount == 1 && info->arraySize == 1 && info->mipCount == 1,
         "counts of the swapchain");
  expect(g_swapchain_count < 2, "too many swapchains");
  GLint bound = 0;
  glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
  Swapchain& made = g_swapchains[g_swapchain_count] = {};
  glGenTextures(k_images, made.textures.data());
  for (const GLuint texture : made.textures) {
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, static_cast<int>(info->width),
                 static_cast<int>(info->height), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  }
  glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(bound));
  *swapchain = handle<XrSwapchain>(static_cast<std::uintptr_t>(10 + g_swapchain_count++));
  return XR_SUCCESS;
}
Swapchain& swapchain_of(XrSwapchain swapchain) {
  return g_swapchains[reinterpret_cast<std::uintptr_t>(swapchain) - 10];
}
XrResult get_images(XrSwapchain swapchain, std::uint32_t capacity, std::uint32_t* count,
                    XrSwapchainImageBaseHeader* images) {
  *count = k_images;
  auto* all = reinterpret_cast<XrSwapchainImageOpenGLKHR*>(images);
  for (std::uint32_t i = 0; i < capacity; ++i) {
    expect(all[i].type == XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR, "image without type");
    all[i].image = swapchain_of(swapchain).textures[i];
  }
  return XR_SUCCESS;
}
XrResult poll_event(XrInstance, XrEventDataBuffer* buffer) {
  expect(buffer->type == XR_TYPE_EVENT_DATA_BUFFER, "event buffer without type");
  XrEventDataSessionStateChanged changed{};
  changed.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED;
  changed.session = handle<XrSession>(2);
  if (g_events == 0) {
    changed.state = XR_SESSION_STATE_IDLE;
  } else if (g_events == 1 && g_log.is_worn) {
    changed.state = XR_SESSION_STATE_READY;
  } else if (g_is_running && g_log.ends_after >= 0 && g_log.frames >= g_log.ends_after) {
    changed.state = XR_SESSION_STATE_LOSS_PENDING;
  } else {
    return XR_EVENT_UNAVAILABLE;
  }
  ++g_events;
  std::memcpy(buffer, &changed, sizeof changed);
  return XR_SUCCESS;
}
XrResult begin_session(XrSession, const XrSessionBeginInfo* info) {
  expect(info->primaryViewConfigurationType == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
         "session begun for another configuration");
  expect(!g_is_running, "session begun twice");
  g_is_running = true;
  return XR_SUCCESS;
}
XrResult end_session(XrSession) {
  g_is_running = false;
  return XR_SUCCESS;
}
XrResult wait_frame(XrSession, const XrFrameWaitInfo*, XrFrameState* state) {
  expect(g_is_running, "frame of a session that is not running");
  expect(!g_has_waited, "frame awaited twice");
  g_has_waited = true;
  state->predictedDisplayTime = 1000 + g_log.frames;
  state->shouldRender = g_log.shows;
  return XR_SUCCESS;
}
XrResult begin_frame(XrSession, const XrFrameBeginInfo*) {
  expect(g_has_waited && !g_has_begun, "frame begun without a wait, or twice");
  g_has_begun = true;
  return XR_SUCCESS;
}
XrResult locate_views(XrSession, const XrViewLocateInfo* info, XrViewState* state, std::uint32_t capacity,
                      std::uint32_t* count, XrView* views) {
  expect(info->displayTime == 1000 + g_log.frames, "views at another time than that of the frame");
  *count = 2;
  if (capacity < 2) return XR_ERROR_SIZE_INSUFFICIENT;
  g_log.head[0] += g_log.tremor;
  state->viewStateFlags = XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
  for (int i = 0; i < 2; ++i) views[i].pose = pose_of_eye(i), views[i].fov = fov_of_eye(i);
  return XR_SUCCESS;
}
XrResult acquire(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo*, std::uint32_t* index) {
  Swapchain& one = swapchain_of(swapchain);
  expect(one.acquired < 0, "image acquired twice");
  one.acquired = one.next, one.is_waited = one.is_released = false;
  one.next = (one.next + 1) % k_images;
  *index = static_cast<std::uint32_t>(one.acquired);
  return XR_SUCCESS;
}
XrResult wait_image(XrSwapchain swapchain, const XrSwapchainImageWaitInfo*) {
  expect(swapchain_of(swapchain).acquired >= 0, "wait for an image that was not acquired");
  swapchain_of(swapchain).is_waited = true;
  return XR_SUCCESS;
}
XrResult release_image(XrSwapchain swapchain, const XrSwapchainImageReleaseInfo*) {
  Swapchain& one = swapchain_of(swapchain);
  expect(one.is_waited, "image released before it was waited for");
  auto& received = g_log.eyes[static_cast<std::size_t>(&one - g_swapchains)];
  received.width = k_width, received.height = k_height;
  received.rgba.resize(static_cast<std::size_t>(4 * k_width * k_height));
  GLint bound = 0;
  glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
  glBindTexture(GL_TEXTURE_2D, one.textures[static_cast<std::size_t>(one.acquired)]);
  glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, received.rgba.data());
  glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(bound));
  one.acquired = -1, one.is_released = true;
  return XR_SUCCESS;
}
XrResult end_frame(XrSession, const XrFrameEndInfo* info) {
  expect(g_has_begun, "frame ended that was not begun");
  expect(info->displayTime == 1000 + g_log.frames, "frame ended for another time");
  expect(info->environmentBlendMode == XR_ENVIRONMENT_BLEND_MODE_OPAQUE, "blend mode");
  if (!g_log.shows) expect(info->layerCount == 0, "pictures although nothing is shown");
  for (std::uint32_t l = 0; l < info->layerCount; ++l) {
    const auto* layer = reinterpret_cast<const XrCompositionLayerProjection*>(info->layers[l]);
    expect(layer->type == XR_TYPE_COMPOSITION_LAYER_PROJECTION && layer->viewCount == 2, "layer");
    for (int i = 0; i < 2; ++i) {
      const XrCompositionLayerProjectionView& view = layer->views[i];
      const XrPosef pose = pose_of_eye(i);
      expect(view.pose.position.x == pose.position.x && view.fov.angleLeft == fov_of_eye(i).angleLeft,
             "a picture with another pose than the located one");
      expect(swapchain_of(view.subImage.swapchain).is_released, "a picture that was not released");
      expect(view.subImage.imageRect.extent.width == k_width, "size of the picture");
    }
  }
  g_has_waited = g_has_begun = false;
  ++g_log.frames;
  return XR_SUCCESS;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) Log* trephine_openxr_log() { return &g_log; }

extern "C" __attribute__((visibility("default"))) XrResult xrGetInstanceProcAddr(
    XrInstance instance, const char* name, PFN_xrVoidFunction* function) {
  const std::pair<const char*, PFN_xrVoidFunction> functions[] = {
#define TREPHINE_ENTRY(name, function) {name, reinterpret_cast<PFN_xrVoidFunction>(function)}
      TREPHINE_ENTRY("xrCreateInstance", create_instance),
      TREPHINE_ENTRY("xrDestroyInstance", destroy_instance),
      TREPHINE_ENTRY("xrGetSystem", get_system),
      TREPHINE_ENTRY("xrGetOpenGLGraphicsRequirementsKHR", get_requirements),
      TREPHINE_ENTRY("xrCreateSession", create_session),
      TREPHINE_ENTRY("xrDestroySession", destroy_session),
      TREPHINE_ENTRY("xrCreateReferenceSpace", create_space),
      TREPHINE_ENTRY("xrEnumerateViewConfigurationViews", get_views),
      TREPHINE_ENTRY("xrEnumerateSwapchainFormats", get_formats),
      TREPHINE_ENTRY("xrCreateSwapchain", create_swapchain),
      TREPHINE_ENTRY("xrEnumerateSwapchainImages", get_images),
      TREPHINE_ENTRY("xrPollEvent", poll_event),
      TREPHINE_ENTRY("xrBeginSession", begin_session),
      TREPHINE_ENTRY("xrEndSession", end_session),
      TREPHINE_ENTRY("xrWaitFrame", wait_frame),
      TREPHINE_ENTRY("xrBeginFrame", begin_frame),
      TREPHINE_ENTRY("xrEndFrame", end_frame),
      TREPHINE_ENTRY("xrLocateViews", locate_views),
      TREPHINE_ENTRY("xrAcquireSwapchainImage", acquire),
      TREPHINE_ENTRY("xrWaitSwapchainImage", wait_image),
      TREPHINE_ENTRY("xrReleaseSwapchainImage", release_image),
#undef TREPHINE_ENTRY
  };
  for (const auto& [known, pointer] : functions)
    if (std::strcmp(known, name) == 0) {
      if (instance == XR_NULL_HANDLE && std::strcmp(name, "xrCreateInstance") != 0)
        return XR_ERROR_HANDLE_INVALID;
      *function = pointer;
      return XR_SUCCESS;
    }
  return XR_ERROR_FUNCTION_UNSUPPORTED;
}
