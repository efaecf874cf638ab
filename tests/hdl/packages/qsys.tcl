# Stands in for Platform Designer while it reads a component: knows the commands that one is made of, and stops at whatever it does
# not know. At its end it prints the ports, a line each.

set known_properties [dict create \
    module {NAME VERSION DISPLAY_NAME DESCRIPTION GROUP INSTANTIATE_IN_SYSTEM_MODULE EDITABLE} \
    clock {clockRate} reset {associatedClock synchronousEdges} conduit {associatedClock associatedReset} \
    avalon_streaming {associatedClock associatedReset dataBitsPerSymbol symbolsPerBeat readyLatency} \
    axi4stream {associatedClock associatedReset} axi4lite {associatedClock associatedReset} \
    avalon {associatedClock associatedReset addressUnits bitsPerSymbol readLatency readWaitTime writeWaitTime maximumPendingReadTransactions}]

# Type to roles: who drives it, as the "end" sees it, and the width, 0 for any.
set known_roles [dict create \
    clock {clk {Input 1}} reset {reset {Input 1} reset_n {Input 1}} \
    avalon_streaming {valid {Input 1} ready {Output 1} data {Input 0} startofpacket {Input 1} endofpacket {Input 1}} \
    axi4stream {tvalid {Input 1} tready {Output 1} tdata {Input 0} tuser {Input 0} tlast {Input 1}} \
    axi4lite {awaddr {Input 0} awprot {Input 3} awvalid {Input 1} awready {Output 1} wdata {Input 32} wstrb {Input 4} wvalid {Input 1} \
        wready {Output 1} bresp {Output 2} bvalid {Output 1} bready {Input 1} araddr {Input 0} arprot {Input 3} arvalid {Input 1} \
        arready {Output 1} rdata {Output 32} rresp {Output 2} rvalid {Output 1} rready {Input 1}} \
    avalon {address {Input 0} read {Input 1} write {Input 1} writedata {Input 32} byteenable {Input 4} waitrequest {Output 1} \
        readdata {Output 32} readdatavalid {Output 1}}]
set optional {tuser tlast awprot arprot startofpacket endofpacket byteenable readdatavalid}

set filesets {}; set interfaces {}; set properties {}; set ports {}; set module {}; set roles {}
proc check {right told} { if {![uplevel 1 [list expr $right]]} { error $told } }

# Version 13.1 knows no AXI4-Lite.
set required ""
foreach version {13.1 18.1} { package ifneeded qsys $version "package provide qsys $version; set required $version" }
package unknown {apply {{name args} { error "there is no package $name of this version: $args" }}}

proc set_module_property {name value} {
    check {$name in [dict get $::known_properties module]} "no property $name of a module"
    dict set ::module $name $value
}
proc add_fileset {name kind callback {display ""}} {
    check {$kind in {QUARTUS_SYNTH SIM_VERILOG SIM_VHDL} && $callback eq ""} "fileset $name"
    check {![dict exists $::filesets $name]} "fileset $name twice"
    dict set ::filesets $name {}
    set ::fileset $name
}
proc set_fileset_property {name property value} {
    check {$property eq "TOP_LEVEL" && [dict exists $::filesets $name]} "fileset $name"
    check {$value eq [dict get $::module NAME]} "fileset $name"
}
proc add_fileset_file {name kind source path {attribute ""}} {
    check {$kind eq "VERILOG" && $source eq "PATH" && $attribute in {"" TOP_LEVEL_FILE}} "file $name"
    check {[file isfile $path]} "no file $path"
    dict lappend ::filesets $::fileset $name
}
proc add_interface {name type direction} {
    check {![dict exists $::interfaces $name]} "interface $name twice"
    check {[dict exists $::known_properties $type] && $type ne "module"} "no interface type $type"
    check {$direction in {start end}} "interface $name"
    check {$::required ne "13.1" || ![string match axi* $type]} "$type needs a later version"
    dict set ::interfaces $name [list $type $direction]
}
proc set_interface_property {name property value} {
    lassign [dict get $::interfaces $name] type
    check {$property in [dict get $::known_properties $type]} "no property $property of $type"
    if {$property eq "associatedClock"} { check {[lindex [dict get $::interfaces $value] 0] eq "clock"} "clock of $name" }
    if {$property eq "associatedReset"} { check {[lindex [dict get $::interfaces $value] 0] eq "reset"} "reset of $name" }
    if {$property eq "synchronousEdges"} { check {$value in {NONE DEASSERT BOTH}} "edges of $name" }
    dict set ::properties $name $property $value
}
proc add_interface_port {name port role direction width} {
    lassign [dict get $::interfaces $name] type end
    check {![dict exists $::ports $port]} "port $port twice"
    check {[string is integer -strict $width] && $width > 0 && $direction in {Input Output}} "port $port"
    if {$type ne "conduit"} {
        check {[dict exists $::known_roles $type $role]} "no role $role in $type"
        lassign [dict get $::known_roles $type $role] as_end bits
        check {($direction eq $as_end) == ($end eq "end")} "direction of $port"
        check {$bits == 0 || $bits == $width} "width of $port"
        check {![dict exists $::roles $name $role]} "role $role of $name twice"
    }
    dict set ::roles $name $role $width
    dict set ::ports $port "$direction $width $name"
}

# The script's folder is where its files are.
set script [lindex $argv 0]
cd [file dirname $script]
source $script

check {$required ne ""} "no version is required"
foreach property {NAME VERSION DISPLAY_NAME GROUP} { check {[dict exists $module $property]} "the module has no $property" }
check {[dict size $filesets] == 3} "filesets"
dict for {name files} $filesets { check {"[dict get $module NAME].v" in $files} "fileset $name without the top module's file" }
dict for {name interface} $interfaces {
    lassign $interface type
    check {[dict exists $roles $name]} "interface $name without ports"
    if {$type ne "clock"} { check {[dict exists $properties $name associatedClock]} "interface $name without a clock" }
    if {$type ni {clock reset conduit}} {
        check {[dict exists $properties $name associatedReset]} "interface $name without a reset"
        dict for {role _} [dict get $known_roles $type] {
            check {$role in $optional || [dict exists $roles $name $role]} "interface $name without $role"
        }
    }
    if {$type eq "avalon_streaming"} {
        set beat [expr {[dict get $properties $name dataBitsPerSymbol] * [dict get $properties $name symbolsPerBeat]}]
        check {$beat == [dict get $roles $name data]} "symbols of $name"
        check {[dict exists $roles $name startofpacket] == [dict exists $roles $name endofpacket]} "packets of $name"
    }
    if {$type eq "avalon"} {
        check {[dict exists $roles $name readdatavalid] == ([dict get $properties $name maximumPendingReadTransactions] > 0)} "reads of $name"
        check {[dict get $properties $name addressUnits] eq "WORDS"} "addresses of $name"
    }
}
dict for {port told} $ports { puts "$port $told [lindex [dict get $interfaces [lindex $told 2]] 0]" }
