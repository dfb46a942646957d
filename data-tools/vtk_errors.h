// Messages of VTK's readers and writers, caught instead of printed.
#pragma once

#include <string>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

namespace trephine::data_tools {

/// Its errors go into `heard`, its warnings nowhere.
inline void listen_to(vtkObject* object, std::string& heard) {
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(&heard);
  command->SetCallback([](vtkObject*, unsigned long event, void* into, void* said) {
    auto& text = *static_cast<std::string*>(into);
    if (event == vtkCommand::ErrorEvent && text.empty())
      text = said ? static_cast<const char*>(said) : "an error";
  });
  object->AddObserver(vtkCommand::ErrorEvent, command);
  object->AddObserver(vtkCommand::WarningEvent, command);
}

}  // namespace trephine::data_tools
