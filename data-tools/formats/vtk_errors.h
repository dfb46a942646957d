// listen_to(): stores the first error of a VTK object instead of printing it.
#pragma once

#include <string>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

namespace trephine::data_tools {

/// Stores the first error of `object` in `error`, which must outlive `object`; discards warnings.
inline void listen_to(vtkObject* object, std::string& error) {
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(&error);
  command->SetCallback([](vtkObject*, unsigned long event, void* target, void* message) {
    auto& text = *static_cast<std::string*>(target);
    if (event == vtkCommand::ErrorEvent && text.empty())
      text = message ? static_cast<const char*>(message) : "an error";
  });
  object->AddObserver(vtkCommand::ErrorEvent, command);
  object->AddObserver(vtkCommand::WarningEvent, command);
}

}  // namespace trephine::data_tools
