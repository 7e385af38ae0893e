; The installer for Windows, made by scripts/build-windows.sh: for one user, without an administrator.
; It is given VERSION, FOLDER (what is installed), OUT (the installer).
Unicode true
Target amd64-unicode
Name "altiro3D ${VERSION}"
OutFile "${OUT}"
InstallDir "$LOCALAPPDATA\Programs\altiro3D"
RequestExecutionLevel user
SetCompressor /SOLID lzma
!include MUI2.nsh
!include FileFunc.nsh
!define MUI_ICON "${FOLDER}\altiro3D.ico"
!define UNINSTALL "Software\Microsoft\Windows\CurrentVersion\Uninstall\altiro3D"
!define PROGRAM "Software\Classes\Applications\altiro3Dview.exe"
!insertmacro MUI_PAGE_WELCOME
!insertmacro MUI_PAGE_LICENSE "${FOLDER}\LICENSE.txt"
!insertmacro MUI_PAGE_COMPONENTS
!insertmacro MUI_PAGE_DIRECTORY
!insertmacro MUI_PAGE_INSTFILES
!insertmacro MUI_UNPAGE_CONFIRM
!insertmacro MUI_UNPAGE_INSTFILES
!insertmacro MUI_LANGUAGE English

!macro supported ending
  WriteRegStr HKCU "${PROGRAM}\SupportedTypes" ".${ending}" ""
  WriteRegStr HKCU "Software\Classes\.${ending}\OpenWithList\altiro3Dview.exe" "" ""
!macroend
!macro unsupported ending
  DeleteRegKey HKCU "Software\Classes\.${ending}\OpenWithList\altiro3Dview.exe"
!macroend
!macro forEachEnding do
  !insertmacro ${do} jpg
  !insertmacro ${do} jpeg
  !insertmacro ${do} jps
  !insertmacro ${do} mpo
  !insertmacro ${do} png
  !insertmacro ${do} pns
  !insertmacro ${do} tif
  !insertmacro ${do} tiff
  !insertmacro ${do} webp
  !insertmacro ${do} heic
  !insertmacro ${do} avif
  !insertmacro ${do} mp4
  !insertmacro ${do} mov
  !insertmacro ${do} mkv
  !insertmacro ${do} webm
!macroend

Section "Programs (needed)"
  SectionIn RO
  SetOutPath "$INSTDIR"
  File /r "${FOLDER}\*"
  WriteUninstaller "$INSTDIR\uninstall.exe"
  CreateShortcut "$SMPROGRAMS\altiro3D.lnk" "$INSTDIR\bin\altiro3Dview.exe" "" "$INSTDIR\altiro3D.ico"
  WriteRegStr HKCU "${UNINSTALL}" DisplayName "altiro3D"
  WriteRegStr HKCU "${UNINSTALL}" DisplayVersion "${VERSION}"
  WriteRegStr HKCU "${UNINSTALL}" DisplayIcon "$INSTDIR\altiro3D.ico"
  WriteRegStr HKCU "${UNINSTALL}" UninstallString '"$INSTDIR\uninstall.exe"'
  WriteRegStr HKCU "${UNINSTALL}" QuietUninstallString '"$INSTDIR\uninstall.exe" /S'
  ${GetSize} "$INSTDIR" "/S=0K" $0 $1 $2
  WriteRegDWORD HKCU "${UNINSTALL}" EstimatedSize $0
SectionEnd

Section "Open with: pictures, quilts, videos"
  WriteRegStr HKCU "${PROGRAM}" FriendlyAppName "altiro3D"
  WriteRegStr HKCU "${PROGRAM}\shell\open\command" "" '"$INSTDIR\bin\altiro3Dview.exe" "%1"'
  !insertmacro forEachEnding supported
SectionEnd

; PowerShell: the texts of this installer are too short for some PATHs.
Section /o "PATH: tools by their names"
  nsExec::Exec `powershell -NoProfile -Command "[Environment]::SetEnvironmentVariable('Path', \
      [Environment]::GetEnvironmentVariable('Path', 'User').TrimEnd(';') + ';$INSTDIR\bin', 'User')"`
  Pop $0
SectionEnd

Section Uninstall
  nsExec::Exec `powershell -NoProfile -Command "[Environment]::SetEnvironmentVariable('Path', \
      ([Environment]::GetEnvironmentVariable('Path', 'User') -split ';' -ne '$INSTDIR\bin' -join ';'), 'User')"`
  Pop $0
  !insertmacro forEachEnding unsupported
  DeleteRegKey HKCU "${PROGRAM}"
  DeleteRegKey HKCU "${UNINSTALL}"
  Delete "$SMPROGRAMS\altiro3D.lnk"
  RMDir /r "$INSTDIR\bin"
  RMDir /r "$INSTDIR\share"
  RMDir /r "$INSTDIR\manual"
  Delete "$INSTDIR\*.txt"
  Delete "$INSTDIR\altiro3D.ico"
  Delete "$INSTDIR\uninstall.exe"
  RMDir "$INSTDIR"
SectionEnd
